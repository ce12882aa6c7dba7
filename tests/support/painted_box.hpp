#pragma once
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "core/changed_object.hpp"
#include "vision/camera/camera_model.hpp"
#include "vision/image.hpp"
#include "vision/stereo/range_image.hpp"

namespace kawara::testing {

/// A picture of it and its true ranges.
struct PaintedView {
  vision::RangeImage ranges;
  std::vector<std::uint8_t> pixels;
  Eigen::Isometry3d map_from_camera;
  vision::ConstImageView picture() const {
    return {pixels.data(), ranges.width_px, ranges.height_px};
  }
};

/// A box on grey ground whose sides are painted with formulas of the place on them that are the
/// same neither mirrored nor turned, and whatever else stands around, red. The places on the sides
/// are derived here anew, not from UprightBox::CornersOf.
struct PaintedBox {
  core::UprightBox box;
  std::vector<Eigen::AlignedBox3d> pillars;  ///< map frame

  /// Width and height of a side as seen from outside (top: front upwards) [m].
  Eigen::Vector2d SizeOf(core::BoxSide side) const {
    switch (side) {
      case core::BoxSide::kFront:
      case core::BoxSide::kRear:
        return {box.size_m.y(), box.size_m.z()};
      case core::BoxSide::kTop:
        return {box.size_m.y(), box.size_m.x()};
      default:
        return {box.size_m.x(), box.size_m.z()};
    }
  }

  /// RGB at a place of a side: to the right and down from its upper left corner [m].
  std::array<double, 3> Paint(core::BoxSide side, double right_m, double down_m) const {
    const Eigen::Vector2d size = SizeOf(side);
    const double number = static_cast<double>(side);
    const double light = 1.0 + 0.35 * std::sin(17.0 * right_m + number) * std::cos(21.0 * down_m);
    return {light * (50.0 + 110.0 * right_m / size.x()), light * (50.0 + 110.0 * down_m / size.y()),
            light * (40.0 + 30.0 * number)};
  }

  PaintedView LookAt(const vision::CameraModel& camera,
                     const Eigen::Isometry3d& map_from_camera) const {
    PaintedView view;
    view.map_from_camera = map_from_camera;
    view.ranges.Reset(camera.width_px(), camera.height_px());
    view.pixels.assign(view.ranges.range_m.size() * 3, 0);
    for (int v = 0; v < camera.height_px(); ++v)
      for (int u = 0; u < camera.width_px(); ++u) {
        const auto ray = camera.Unproject({u, v});
        if (!ray) continue;
        const Hit hit = Cast(map_from_camera.translation(), map_from_camera.linear() * *ray);
        if (!std::isfinite(hit.range_m)) continue;
        const std::size_t i = view.ranges.index(u, v);
        view.ranges.range_m[i] = static_cast<float>(hit.range_m);
        view.ranges.sd_m[i] = static_cast<float>(0.01 * hit.range_m);
        for (std::size_t c = 0; c < 3; ++c)
          view.pixels[3 * i + c] = static_cast<std::uint8_t>(std::lround(hit.rgb[c]));
      }
    return view;
  }

 private:
  struct Hit {
    double range_m = std::numeric_limits<double>::infinity();
    std::array<double, 3> rgb{};
  };

  static std::optional<double> Enter(const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                                     const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
    const Eigen::Array3d a = (low - from).array() / ray.array();
    const Eigen::Array3d b = (high - from).array() / ray.array();
    const double in = a.min(b).maxCoeff(), out = a.max(b).minCoeff();
    if (in <= out && in > 0.0) return in;
    return std::nullopt;
  }

  Hit Cast(const Eigen::Vector3d& from, const Eigen::Vector3d& ray) const {
    Hit best;
    if (ray.z() < 0.0) best = {-from.z() / ray.z(), {110, 110, 110}};
    for (const auto& pillar : pillars)
      if (const auto in = Enter(pillar.min(), pillar.max(), from, ray); in && *in < best.range_m)
        best = {*in, {250, 0, 0}};
    // The box's own frame: x along its heading, y to the left, z up.
    Eigen::Matrix3d R_box_map;
    const double s = std::sin(box.heading_rad), c = std::cos(box.heading_rad);
    R_box_map << s, c, 0, -c, s, 0, 0, 0, 1;
    const Eigen::Vector3d half = box.size_m / 2, p = R_box_map * (from - box.centre_m);
    const auto in = Enter(-half, half, p, R_box_map * ray);
    if (!in || *in >= best.range_m) return best;
    const Eigen::Vector3d at = p + *in * (R_box_map * ray);
    Eigen::Index axis = 0;
    (at.cwiseAbs() - half).maxCoeff(&axis);
    const bool positive = at[axis] > 0.0;
    if (axis == 2) return {*in, Paint(core::BoxSide::kTop, half.y() - at.y(), half.x() - at.x())};
    const double down = half.z() - at.z();
    if (axis == 0)
      return {*in, positive ? Paint(core::BoxSide::kFront, half.y() + at.y(), down)
                            : Paint(core::BoxSide::kRear, half.y() - at.y(), down)};
    return {*in, positive ? Paint(core::BoxSide::kLeft, half.x() - at.x(), down)
                          : Paint(core::BoxSide::kRight, half.x() + at.x(), down)};
  }
};

}  // namespace kawara::testing
