#pragma once
#include <Eigen/Core>

#include "core/time.hpp"
#include "estimation/error_state.hpp"

namespace kawara::estimation {

/// Inertial measurement of one interval: constant inside it but for what the interval before shows
/// of its slope.
struct ImuInterval {
  double duration_s = 0.0;  ///< of the whole sample, of which a part may be used
  Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();  ///< as measured
  Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Zero();
  Eigen::Vector3d previous_rate_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d previous_specific_force_mps2 = Eigen::Vector3d::Zero();
};

/// Moves the nominal state `dt_s` on: attitude with coning, velocity with sculling, Earth rate,
/// transport rate, Coriolis and normal gravity, position on WGS 84. `hold_attitude`: the body
/// stands still on the Earth, the gyros are not asked. Source: Savage, Strapdown Inertial
/// Navigation Integration Algorithm Design (AIAA JGCD 21, 1998), two-sample terms.
void Strapdown(NominalState& state, const ImuInterval& imu, double dt_s, bool hold_attitude);

}  // namespace kawara::estimation
