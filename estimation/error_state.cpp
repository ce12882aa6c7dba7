#include "estimation/error_state.hpp"

#include <cmath>

#include "estimation/earth.hpp"
#include "estimation/rotation.hpp"

namespace kawara::estimation {

core::Geodetic Displaced(const core::Geodetic& from, const Eigen::Vector3d& ned_m) {
  const auto radii = RadiiAt(from.lat_rad);
  core::Geodetic to = from;
  to.lat_rad += ned_m.x() / (radii.meridian_m + from.h_ellipsoidal_m);
  to.lon_rad +=
      ned_m.y() / ((radii.prime_vertical_m + from.h_ellipsoidal_m) * std::cos(from.lat_rad));
  to.lon_rad = core::WrapPi(to.lon_rad);
  to.h_ellipsoidal_m -= ned_m.z();
  return to;
}

Eigen::Vector3d Displacement(const core::Geodetic& from, const core::Geodetic& to) {
  const auto radii = RadiiAt(from.lat_rad);
  return {(to.lat_rad - from.lat_rad) * (radii.meridian_m + from.h_ellipsoidal_m),
          core::WrapPi(to.lon_rad - from.lon_rad) *
              (radii.prime_vertical_m + from.h_ellipsoidal_m) * std::cos(from.lat_rad),
          from.h_ellipsoidal_m - to.h_ellipsoidal_m};
}

void NominalState::Correct(const ErrorVector& error) {
  position = Displaced(position, error.segment<3>(kPosition));
  velocity_ned_mps += error.segment<3>(kVelocity);
  ned_from_body = (Rotation(error.segment<3>(kAttitude)) * ned_from_body).normalized();
  gyro_bias_radps += error.segment<3>(kGyroBias);
  accel_bias_mps2 += error.segment<3>(kAccelBias);
  gyro_scale += error.segment<3>(kGyroScale);
  accel_scale += error.segment<3>(kAccelScale);
  gnss_coloured_ned_m += error.segment<3>(kGnssColoured);
  time_offset_s += error(kTimeOffset);
  velocity_delay_s += error(kVelocityDelay);
  speed_scale += error(kSpeedScale);
  turn_scale += error(kTurnScale);
  mount_pitch_rad += error(kMountPitch);
  mount_yaw_rad += error(kMountYaw);
  axle_m += error(kAxle);
  ahrs_heading_rad += error(kAhrsHeading);
  squat_rad_per_mps2 += error(kSquat);
  sideslip_rad_per_mps2 += error(kSideslip);
  gyro_cross += error.segment<2>(kGyroCross);
}

}  // namespace kawara::estimation
