#pragma once
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "vision/camera/camera_model.hpp"
#include "vision/image.hpp"
#include "vision/stereo/range_image.hpp"

namespace kawara::testing {

/// Level ground (z = 0) with upright boxes on it, painted with a pattern that is a formula of the
/// place: a world whose every distance image, picture and surface is known exactly. Map frame, m.
struct BoxWorld {
  std::vector<Eigen::AlignedBox3d> boxes;
  bool has_ground = true;

  /// Along a unit ray; infinity: sky.
  double Range(const Eigen::Vector3d& from, const Eigen::Vector3d& ray) const {
    double best = std::numeric_limits<double>::infinity();
    if (has_ground && ray.z() < 0.0 && from.z() > 0.0) best = -from.z() / ray.z();
    for (const auto& box : boxes) {
      const Eigen::Array3d a = (box.min() - from).array() / ray.array();
      const Eigen::Array3d b = (box.max() - from).array() / ray.array();
      const double in = a.min(b).maxCoeff(), out = a.max(b).minCoeff();
      if (in <= out && in > 0.0) best = std::min(best, in);
    }
    return best;
  }

  /// To the nearest surface, from any side.
  double DistanceToSurface(const Eigen::Vector3d& p) const {
    double best = has_ground ? std::abs(p.z()) : std::numeric_limits<double>::infinity();
    for (const auto& box : boxes) {
      if (box.contains(p)) {
        best = std::min(best, std::min((p - box.min()).minCoeff(), (box.max() - p).minCoeff()));
      } else {
        best = std::min(best, box.exteriorDistance(p));
      }
    }
    return best;
  }

  static std::array<std::uint8_t, 3> Colour(const Eigen::Vector3d& p) {
    const auto wave = [](double v) {
      return static_cast<std::uint8_t>(127.5 + 100.0 * std::sin(v));
    };
    return {wave(3.0 * p.x()), wave(3.0 * p.y() + 1.0), wave(3.0 * p.z() + 2.0)};
  }
};

/// What a camera sees of it: exact ranges, or with errors of `sd(range)`.
struct BoxWorldView {
  vision::RangeImage ranges;
  std::vector<std::uint8_t> pixels;
  Eigen::Isometry3d map_from_camera;
  vision::ConstImageView picture() const {
    return {pixels.data(), ranges.width_px, ranges.height_px};
  }
};

template <class Deviation>
BoxWorldView LookAt(const BoxWorld& world, const vision::CameraModel& camera,
                    const Eigen::Isometry3d& map_from_camera, const Deviation& sd_m,
                    std::mt19937_64& random) {
  BoxWorldView view;
  view.map_from_camera = map_from_camera;
  view.ranges.Reset(camera.width_px(), camera.height_px());
  view.pixels.assign(view.ranges.range_m.size() * 3, 0);
  std::normal_distribution<double> normal;
  for (int v = 0; v < camera.height_px(); ++v) {
    for (int u = 0; u < camera.width_px(); ++u) {
      const auto ray = camera.Unproject({u, v});
      if (!ray) continue;
      const Eigen::Vector3d direction = map_from_camera.linear() * *ray;
      const double range = world.Range(map_from_camera.translation(), direction);
      if (!std::isfinite(range)) continue;
      const std::size_t i = view.ranges.index(u, v);
      const double sd = sd_m(range);
      view.ranges.range_m[i] = static_cast<float>(range + sd * normal(random));
      view.ranges.sd_m[i] = static_cast<float>(sd);
      const auto rgb = BoxWorld::Colour(map_from_camera.translation() + range * direction);
      std::copy(rgb.begin(), rgb.end(), view.pixels.begin() + static_cast<std::ptrdiff_t>(3 * i));
    }
  }
  return view;
}

/// An upright camera at `position_m`, looking `heading_rad` clockwise from north (map y).
inline Eigen::Isometry3d UprightCamera(const Eigen::Vector3d& position_m, double heading_rad) {
  Eigen::Isometry3d map_from_camera = Eigen::Isometry3d::Identity();
  const double s = std::sin(heading_rad), c = std::cos(heading_rad);
  // Columns: the camera's X (up), Y (right), Z (forward) in east, north, up.
  map_from_camera.linear() << 0, c, s, 0, -s, c, 1, 0, 0;
  map_from_camera.translation() = position_m;
  return map_from_camera;
}

}  // namespace kawara::testing
