#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace kawara::estimation {

/// The rotation of a rotation vector [rad]; exact for any size.
inline Eigen::Quaterniond Rotation(const Eigen::Vector3d& vector_rad) {
  const double angle2 = vector_rad.squaredNorm();
  if (angle2 < 1e-8) {  // series: sin(a/2)/a and cos(a/2) to 1e-17
    const double scale = 0.5 - angle2 / 48.0;
    return {1.0 - angle2 / 8.0 + angle2 * angle2 / 384.0, scale * vector_rad.x(),
            scale * vector_rad.y(), scale * vector_rad.z()};
  }
  const double angle = std::sqrt(angle2);
  const double scale = std::sin(0.5 * angle) / angle;
  return {std::cos(0.5 * angle), scale * vector_rad.x(), scale * vector_rad.y(),
          scale * vector_rad.z()};
}

/// The shortest rotation vector [rad] of a rotation.
inline Eigen::Vector3d RotationVector(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const double sine = q.vec().norm();
  if (sine < 1e-12) return 2.0 * sign * q.vec();
  return q.vec() * (2.0 * sign * std::atan2(sine, sign * q.w()) / sine);
}

}  // namespace kawara::estimation
