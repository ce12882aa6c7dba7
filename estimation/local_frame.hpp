#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/geodesy.hpp"

/// Changes of axes.
namespace kawara::estimation {

inline Eigen::Matrix3d EnuFromNed() {
  return (Eigen::Matrix3d() << 0, 1, 0, 1, 0, 0, 0, 0, -1).finished();
}
inline Eigen::Vector3d EnuFromNed(const Eigen::Vector3d& ned) {
  return {ned.y(), ned.x(), -ned.z()};
}
inline Eigen::Vector3d NedFromEnu(const Eigen::Vector3d& enu) {
  return {enu.y(), enu.x(), -enu.z()};
}

/// CrossMatrix(a) * b = a x b.
inline Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& a) {
  return (Eigen::Matrix3d() << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0).finished();
}

/// East, north, up [m] from `from` to `to` in the tangent plane at `from`.
inline Eigen::Vector3d EnuBetween(const core::Geodetic& from, const core::Geodetic& to) {
  return EnuFromNed(core::NedBetween(from, to));
}

/// How roll, pitch, yaw (rows) change with a small rotation in NED put in front of the attitude.
/// Near the vertical, where roll and yaw are one, bounded.
inline Eigen::Matrix3d EulerFromRotationVector(const core::Attitude& a) {
  const double cos_yaw = std::cos(a.yaw_rad), sin_yaw = std::sin(a.yaw_rad);
  const double cos_pitch = std::max(0.05, std::cos(a.pitch_rad));
  const double tan_pitch = std::sin(a.pitch_rad) / cos_pitch;
  return (Eigen::Matrix3d() << cos_yaw / cos_pitch, sin_yaw / cos_pitch, 0, -sin_yaw, cos_yaw, 0,
          tan_pitch * cos_yaw, tan_pitch * sin_yaw, 1)
      .finished();
}

}  // namespace kawara::estimation
