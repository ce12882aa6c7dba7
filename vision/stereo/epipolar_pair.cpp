#include "vision/stereo/epipolar_pair.hpp"

#include <cmath>
#include <limits>

namespace kawara::vision {

core::Expected<EpipolarPair> EpipolarPair::FromPoses(const Eigen::Isometry3d& map_from_a,
                                                     const Eigen::Isometry3d& map_from_b) {
  constexpr double kShortest = 1e-3;
  const Eigen::Vector3d step = map_from_b.translation() - map_from_a.translation();
  EpipolarPair pair;
  pair.baseline_m = step.norm();
  if (!(pair.baseline_m >= kShortest)) {
    return core::Fail(
        core::ErrorCode::kInvalidArgument,
        "the two pictures were taken from the same place (less than 1 mm apart): stereo needs "
        "frames between which the robot has moved");
  }
  const Eigen::Vector3d e0 = step / pair.baseline_m;
  // A's own up axis; when the robot goes straight along it, its right axis.
  Eigen::Vector3d up = map_from_a.linear().col(0);
  if (std::abs(up.dot(e0)) > 0.95) up = map_from_a.linear().col(1);
  Eigen::Matrix3d map_from_epipolar;
  map_from_epipolar.col(0) = e0;
  map_from_epipolar.col(1) = (up - up.dot(e0) * e0).normalized();
  map_from_epipolar.col(2) = e0.cross(map_from_epipolar.col(1));
  pair.a_from_epipolar = map_from_a.linear().transpose() * map_from_epipolar;
  pair.b_from_epipolar = map_from_b.linear().transpose() * map_from_epipolar;
  return pair;
}

Eigen::Vector3d EpipolarPair::Ray(double alpha_rad, double beta_rad) {
  const double across = std::sin(alpha_rad);
  return {std::cos(alpha_rad), across * std::cos(beta_rad), across * std::sin(beta_rad)};
}

double EpipolarPair::Range(double alpha_rad, double delta_rad) const {
  if (!(delta_rad > 0.0)) return std::numeric_limits<double>::infinity();
  return baseline_m * std::sin(alpha_rad + delta_rad) / std::sin(delta_rad);
}

double EpipolarPair::Disparity(double alpha_rad, double range_m) const {
  return std::atan2(baseline_m * std::sin(alpha_rad), range_m - baseline_m * std::cos(alpha_rad));
}

}  // namespace kawara::vision
