#include "vision/camera/equirectangular_camera.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::vision {

PanoramaGeometry PanoramaGeometry::Full(int width_px, int height_px) {
  return {width_px, height_px, width_px, height_px, 0, 0};
}

PanoramaGeometry PanoramaGeometry::Band(int width_px, const ElevationRange& elevations) {
  const int full_height_px = width_px / 2;
  const auto row = [&](double elevation_rad) {
    const double v = (0.5 - elevation_rad / core::kPi) * full_height_px;
    return static_cast<int>(std::clamp(std::lround(v), 0L, static_cast<long>(full_height_px)));
  };
  const int top_px = std::min(row(elevations.top_rad), std::max(0, full_height_px - 1));
  const int bottom_px = std::max(row(elevations.bottom_rad), top_px + 1);
  return {width_px, bottom_px - top_px, width_px, full_height_px, 0, top_px};
}

PanoramaGeometry PanoramaGeometry::Resized(int new_width_px) const {
  const double scale = static_cast<double>(new_width_px) / std::max(1, width_px);
  const auto scaled = [&](int px) { return static_cast<int>(std::lround(px * scale)); };
  PanoramaGeometry g;
  g.width_px = new_width_px;
  g.height_px = std::max(1, scaled(height_px));
  g.left_px = scaled(left_px);
  g.top_px = scaled(top_px);
  g.full_width_px = std::max(scaled(full_width_px), g.left_px + g.width_px);
  g.full_height_px = std::max(scaled(full_height_px), g.top_px + g.height_px);
  return g;
}

core::Expected<EquirectangularCamera> EquirectangularCamera::Create(const PanoramaGeometry& g) {
  const bool inside = g.width_px > 0 && g.height_px > 0 && g.full_width_px > 0 &&
                      g.full_height_px > 0 && g.left_px >= 0 && g.top_px >= 0 &&
                      g.left_px <= g.full_width_px - g.width_px &&
                      g.top_px <= g.full_height_px - g.height_px;
  if (!inside) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "equirectangular camera: the crop of " + std::to_string(g.width_px) + " x " +
                          std::to_string(g.height_px) + " px at " + std::to_string(g.left_px) +
                          ", " + std::to_string(g.top_px) + " is not inside a panorama of " +
                          std::to_string(g.full_width_px) + " x " +
                          std::to_string(g.full_height_px));
  }
  return EquirectangularCamera(g);
}

EquirectangularCamera::EquirectangularCamera(const PanoramaGeometry& geometry) : g_(geometry) {}

std::optional<Eigen::Vector2d> EquirectangularCamera::Project(
    const Eigen::Vector3d& ray_camera) const {
  const double horizontal = std::hypot(ray_camera.y(), ray_camera.z());
  if (horizontal == 0.0 && ray_camera.x() == 0.0) return {};
  const double theta = std::atan2(ray_camera.y(), ray_camera.z());
  const double phi = std::atan2(ray_camera.x(), horizontal);
  double u = (theta / (2.0 * core::kPi) + 0.5) * g_.full_width_px - 0.5 - g_.left_px;
  if (u >= g_.full_width_px - 0.5 - g_.left_px)
    u -= g_.full_width_px;  // theta = +pi is column -0.5
  const double v = (0.5 - phi / core::kPi) * g_.full_height_px - 0.5 - g_.top_px;
  // Written so that NaN is outside.
  if (!(u >= -0.5 && u <= g_.width_px - 0.5 && v >= -0.5 && v <= g_.height_px - 0.5)) return {};
  return Eigen::Vector2d(u, v);
}

std::optional<Eigen::Vector3d> EquirectangularCamera::Unproject(
    const Eigen::Vector2d& pixel_px) const {
  const double u = pixel_px.x();
  const double v = pixel_px.y();
  if (!(u >= -0.5 && u <= g_.width_px - 0.5 && v >= -0.5 && v <= g_.height_px - 0.5)) return {};
  const double theta = ((u + g_.left_px + 0.5) / g_.full_width_px - 0.5) * 2.0 * core::kPi;
  const double phi = (0.5 - (v + g_.top_px + 0.5) / g_.full_height_px) * core::kPi;
  return Eigen::Vector3d(std::sin(phi), std::cos(phi) * std::sin(theta),
                         std::cos(phi) * std::cos(theta));
}

ElevationRange EquirectangularCamera::Elevations() const {
  const double top = (0.5 - static_cast<double>(g_.top_px) / g_.full_height_px) * core::kPi;
  const double bottom =
      (0.5 - static_cast<double>(g_.top_px + g_.height_px) / g_.full_height_px) * core::kPi;
  return {bottom, top};
}

}  // namespace kawara::vision
