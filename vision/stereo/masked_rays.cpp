#include "vision/stereo/masked_rays.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "core/check.hpp"

namespace kawara::vision {
namespace {

/// So that whole vectors can be read at the end.
constexpr std::size_t kPad = 16;

}  // namespace

MaskedRays::MaskedRays(const CameraModel& camera, const std::vector<std::uint8_t>& mask)
    : width_px_(camera.width_px()), height_px_(camera.height_px()) {
  const auto width = static_cast<std::size_t>(width_px_);
  const std::size_t pixels = width * static_cast<std::size_t>(height_px_);
  CORE_CHECK(mask.empty() || mask.size() == pixels);
  for (auto* component : {&x_, &y_, &z_}) {
    component->assign(pixels + kPad, std::numeric_limits<float>::quiet_NaN());
  }
  seen_.assign(pixels, 0);
  for (std::size_t i = 0; i < pixels; ++i) {
    if (!mask.empty() && mask[i] == 0) continue;
    const auto ray =
        camera.Unproject({static_cast<double>(i % width), static_cast<double>(i / width)});
    if (!ray) continue;
    x_[i] = static_cast<float>(ray->x());
    y_[i] = static_cast<float>(ray->y());
    z_[i] = static_cast<float>(ray->z());
    seen_[i] = 1;
  }
}

void MaskedRays::Pack(const ConstImageView& picture, std::vector<std::uint32_t>& rgbx) const {
  CORE_CHECK(picture.width_px == width_px_ && picture.height_px == height_px_);
  rgbx.resize(seen_.size());
  const std::uint8_t* from = picture.data;
  for (std::size_t i = 0; i < seen_.size(); ++i, from += kRgbBytes) {
    const std::uint32_t word = static_cast<std::uint32_t>(from[0]) |
                               static_cast<std::uint32_t>(from[1]) << 8 |
                               static_cast<std::uint32_t>(from[2]) << 16 | 0xFF000000U;
    rgbx[i] = seen_[i] != 0 ? word : 0U;
  }
}

double MeanResolution(const MaskedRays& rays) {
  // Solid angle of a pixel: the cross product of its ray's steps to the right and down.
  double total = 0.0;
  std::size_t pixels = 0;
  constexpr int kEvery = 8;
  const auto width = static_cast<std::size_t>(rays.width_px());
  for (int v = 0; v + 1 < rays.height_px(); v += kEvery) {
    for (int u = 0; u + 1 < rays.width_px(); u += kEvery) {
      const std::size_t i = static_cast<std::size_t>(v) * width + static_cast<std::size_t>(u);
      if (!rays.seen(i) || !rays.seen(i + 1) || !rays.seen(i + width)) continue;
      const auto ray = [&](std::size_t k) {
        return Eigen::Vector3f(rays.x()[k], rays.y()[k], rays.z()[k]);
      };
      const Eigen::Vector3f right = ray(i + 1) - ray(i), down = ray(i + width) - ray(i);
      total += static_cast<double>(right.cross(down).norm());
      ++pixels;
    }
  }
  return pixels == 0 ? 0.0 : std::sqrt(static_cast<double>(pixels) / total);
}

}  // namespace kawara::vision
