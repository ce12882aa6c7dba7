#pragma once
#include <Eigen/Geometry>

namespace kawara::vision {

/// v x w = Skew(v) * w.
inline Eigen::Matrix3d Skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d skew;
  skew << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return skew;
}

/// The rotation by |turn_rad| about it.
inline Eigen::Matrix3d Exp(const Eigen::Vector3d& turn_rad) {
  const double angle = turn_rad.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity() + Skew(turn_rad);
  return Eigen::AngleAxisd(angle, turn_rad / angle).toRotationMatrix();
}

/// The inverse, for turns of less than half a circle.
inline Eigen::Vector3d Log(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

}  // namespace kawara::vision
