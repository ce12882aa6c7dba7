#include "sim/vehicle/true_inertial.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "sim/vehicle/normal_gravity.hpp"

namespace kawara::sim {
namespace {

Eigen::Vector3d EarthRateEnu(const core::Geodetic& origin) {
  return {0.0, kEarthRate_radps * std::cos(origin.lat_rad),
          kEarthRate_radps * std::sin(origin.lat_rad)};
}

Eigen::Vector3d GravityEnu(const Trajectory& trajectory, const Eigen::Vector3d& lever_frd_m,
                           double since_begin_s) {
  const core::Geodetic place = trajectory.GeodeticAt(
      trajectory.begin() + core::DurationFromSeconds(since_begin_s), lever_frd_m);
  return trajectory.RotationNedFromEnu(place).transpose() * NormalGravityNed(place);
}

Inertial Feel(const MotionState& state, const Eigen::Vector3d& lever_frd_m,
              const Eigen::Vector3d& earth_rate_enu, const Eigen::Vector3d& gravity_enu) {
  const Eigen::Matrix3d R_body_enu = state.R_enu_body.transpose();
  const Eigen::Vector3d coriolis = 2.0 * earth_rate_enu.cross(state.PointVelocityEnu(lever_frd_m));
  return {state.rate_body_radps + R_body_enu * earth_rate_enu,
          R_body_enu * (state.PointAccelerationEnu(lever_frd_m) + coriolis - gravity_enu)};
}

}  // namespace

Inertial InertialAt(const Trajectory& trajectory, const Eigen::Vector3d& lever_frd_m,
                    double since_begin_s) {
  return Feel(trajectory.AtSeconds(since_begin_s), lever_frd_m, EarthRateEnu(trajectory.origin()),
              GravityEnu(trajectory, lever_frd_m, since_begin_s));
}

Inertial MeanInertial(const Trajectory& trajectory, const Eigen::Vector3d& lever_frd_m,
                      double from_s, double to_s) {
  struct Node {
    double place, weight;  // of [-1, 1], weights for a sum of 1
  };
  static constexpr std::array<Node, 4> kNodes{{{-0.8611363115940526, 0.17392742256872692},
                                               {-0.3399810435848563, 0.32607257743127308},
                                               {0.3399810435848563, 0.32607257743127308},
                                               {0.8611363115940526, 0.17392742256872692}}};
  const double middle_s = 0.5 * (from_s + to_s);
  const Eigen::Vector3d earth_rate = EarthRateEnu(trajectory.origin());
  // Over the centimetres of a sample gravity changes by less than 1e-7 m/s^2.
  const Eigen::Vector3d gravity = GravityEnu(trajectory, lever_frd_m, middle_s);
  Inertial mean;
  for (const Node& node : kNodes) {
    const MotionState state = trajectory.AtSeconds(middle_s + 0.5 * node.place * (to_s - from_s));
    const Inertial now = Feel(state, lever_frd_m, earth_rate, gravity);
    mean.rate_radps += node.weight * now.rate_radps;
    mean.specific_force_mps2 += node.weight * now.specific_force_mps2;
  }
  return mean;
}

}  // namespace kawara::sim
