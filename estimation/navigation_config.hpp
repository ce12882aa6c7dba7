#pragma once
#include <Eigen/Core>
#include <cstdint>

#include "core/geodesy.hpp"
#include "core/time.hpp"
#include "estimation/sensor_profile.hpp"

namespace kawara::estimation {

/// May the filter take it that the vehicle moves neither sideways nor upwards?
enum class ConstraintMode : std::uint8_t {
  kOff,   ///< carried by hand, flying, sailing
  kAuto,  ///< watched while fixes are good, and believed as far as it holds
};

/// Errors of GNSS positions and velocities beyond what the receiver states.
struct GnssErrors {
  /// A receiver's stated variance is taken as white plus a part that stays for `coloured_time`:
  /// multipath and ionosphere do not change from epoch to epoch.
  double white_share = 0.6;
  double coloured_share = 0.6;
  double coloured_time_s = 25.0;
  double float_white_share = 0.1;
  double float_coloured_share = 1.2;
  double float_coloured_time_s = 20.0;
  double min_position_sd_m = 0.008;
  double velocity_floor_mps = 0.05;  ///< sd never below
  double velocity_delay_sd_s = 0.1;  ///< receivers filter their velocity: unknown delay, estimated
};

/// Chi-square gates and the patience of trust.
struct TrustConfig {
  double fix_gate = 20.0;  ///< NIS of a position (3 degrees of freedom; 16.3 is one in 1000)
  /// A wrong ambiguity is a decimetre at least; what the inertial unit misjudged since the last fix
  /// is less. Innovations below this are never called a wrong fix.
  double min_jump_horizontal_m = 0.15;
  double min_jump_down_m = 0.25;
  double velocity_gate = 16.3;  ///< of a velocity
  double readmit_s = 0.5;       ///< fixes must agree this long before they are believed again
  double concede_s = 25.0;      ///< consistent fixes that contradict this long are right after all
  /// After an outage without wheels it is the inertial unit that is likely to be wrong: gates open
  /// so many times wider, and patience ends sooner.
  double outage_s = 3.0;  ///< that long without a believed position is an outage
  double outage_gate_factor = 15.0;
  double outage_concede_s = 1.0;
  double lost_after_s = 1.0;  ///< without a believed position: dead reckoning
};

struct NavigationConfig {
  ImuNoise imu;
  Eigen::Vector3d lever_arm_frd_m = Eigen::Vector3d::Zero();  ///< IMU to antenna
  GnssErrors gnss;
  TrustConfig trust;
  ConstraintMode constraint = ConstraintMode::kAuto;
  /// IMU stamps against GNSS epochs: unknown offset, 1 sigma [s]; 0: they agree.
  double time_offset_sd_s = 0.15;
  double odometry_speed_sd_mps = 0.03;
  double odometry_speed_scale_sd = 0.03;
  double odometry_turn_sd_radps = 0.03;
  double odometry_turn_scale_sd = 0.3;            ///< skid steer turns less than its wheels say
  double mount_sd_rad = 5.0 * core::kRadFromDeg;  ///< IMU axes against the vehicle's
  double axle_sd_m = 1.0;  ///< how far forward of the IMU the axle that does not slide may be
  double squat_sd_rad_per_mps2 = 0.003;     ///< springs: a sixth of a degree per m/s^2
  double sideslip_sd_rad_per_mps2 = 0.002;  ///< tyres
  /// The unit's own attitude: wide, because its error lasts.
  double ahrs_level_sd_rad = 2.0 * core::kRadFromDeg;
  double ahrs_heading_sd_rad = 10.0 * core::kRadFromDeg;
  /// Heading of a GNSS receiver with two antennas where it states no deviation.
  double two_antenna_sd_rad = 0.5 * core::kRadFromDeg;
  core::Duration max_lateness = core::Milliseconds(500);
};

}  // namespace kawara::estimation
