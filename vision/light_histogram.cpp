#include "vision/light_histogram.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::vision {
namespace {

bool IsInside(const MeteringArea& area, int u, int v) {
  if (area.outer_px <= 0.0) return true;
  const double radius = std::hypot(u - area.center_u_px, v - area.center_v_px);
  return radius >= area.inner_px && radius <= area.outer_px;
}

template <class LumaAt>
LightHistogram Measure(int width_px, int height_px, const MeteringArea& area, LumaAt luma_at) {
  LightHistogram histogram;
  const double pixels = static_cast<double>(width_px) * height_px;
  const int step = std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / kMeteredPixels))));
  for (int v = step / 2; v < height_px; v += step) {
    for (int u = step / 2; u < width_px; u += step) {
      if (IsInside(area, u, v)) histogram.Add(luma_at(u, v));
    }
  }
  return histogram;
}

}  // namespace

double LightHistogram::TrimmedMean(double gamma) const {
  if (total == 0) return 0.0;
  const double cut = 0.1 * total;
  double below = 0.0, sum = 0.0, weight = 0.0;
  for (std::size_t level = 0; level < count.size(); ++level) {
    const double begin = std::max(below, cut);
    below += count[level];
    const double end = std::min(below, total - cut);
    if (end <= begin) continue;
    sum += (end - begin) * std::pow(static_cast<double>(level) / 255.0, gamma);
    weight += end - begin;
  }
  return weight > 0.0 ? sum / weight : 0.0;
}

double LightHistogram::SaturatedShare() const {
  constexpr std::size_t kSaturated = 250;
  if (total == 0) return 0.0;
  std::uint32_t saturated = 0;
  for (std::size_t level = kSaturated; level < count.size(); ++level) saturated += count[level];
  return static_cast<double>(saturated) / total;
}

LightHistogram MeasureLight(const ConstImageView& picture, const MeteringArea& area) {
  return Measure(picture.width_px, picture.height_px, area, [&picture](int u, int v) {
    const std::uint8_t* const rgb = picture.row(v) + 3 * static_cast<std::ptrdiff_t>(u);
    return static_cast<std::uint8_t>((299 * rgb[0] + 587 * rgb[1] + 114 * rgb[2] + 500) / 1000);
  });
}

LightHistogram MeasureGreyLight(const std::uint8_t* grey, int width_px, int height_px,
                                const MeteringArea& area) {
  return Measure(width_px, height_px, area, [grey, width_px](int u, int v) {
    return grey[static_cast<std::ptrdiff_t>(v) * width_px + u];
  });
}

}  // namespace kawara::vision
