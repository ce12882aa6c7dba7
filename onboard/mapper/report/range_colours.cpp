#include "onboard/mapper/report/range_colours.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace kawara::mapper {
namespace {

constexpr int kLevels = 256;

std::array<Rgb, kLevels> MakeColours() {
  cv::Mat levels(1, kLevels, CV_8UC1), bgr;
  for (int i = 0; i < kLevels; ++i) levels.at<std::uint8_t>(0, i) = static_cast<std::uint8_t>(i);
  cv::applyColorMap(levels, bgr, cv::COLORMAP_TURBO);
  std::array<Rgb, kLevels> colours{};
  for (int i = 0; i < kLevels; ++i) {
    const auto& c = bgr.at<cv::Vec3b>(0, i);
    colours[static_cast<std::size_t>(i)] = {c[2], c[1], c[0]};
  }
  return colours;
}

}  // namespace

Rgb RangeColour(float range_m) {
  static const std::array<Rgb, kLevels> colours = MakeColours();
  if (std::isnan(range_m)) return {0, 0, 0};
  constexpr float kNearM = 1.0F, kFarM = 20.0F;
  const float nearness =
      (1.0F / std::max(range_m, kNearM) - 1.0F / kFarM) / (1.0F / kNearM - 1.0F / kFarM);
  // The root: most of what a survey sees is nearer to the far end.
  const float level = 255.0F * std::sqrt(std::clamp(nearness, 0.0F, 1.0F));
  return colours[static_cast<std::size_t>(level)];
}

std::vector<std::uint8_t> RangeColours(const vision::RangeImage& ranges) {
  std::vector<std::uint8_t> rgb;
  rgb.reserve(3 * ranges.range_m.size());
  for (const float range : ranges.range_m) {
    const Rgb colour = RangeColour(range);
    rgb.insert(rgb.end(), colour.begin(), colour.end());
  }
  return rgb;
}

}  // namespace kawara::mapper
