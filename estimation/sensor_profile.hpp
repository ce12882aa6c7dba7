#pragma once
#include <optional>
#include <span>
#include <string_view>

namespace kawara::estimation {

/// The errors of an inertial unit as a filter needs them: Allan figures and what the data sheet
/// says of bias and scale. Densities are of one axis, all axes alike.
struct ImuNoise {
  double gyro_arw_rad_rts = 0.0;    ///< angle random walk [rad/sqrt(s)]
  double accel_vrw_mps_rts = 0.0;   ///< velocity random walk [m/s/sqrt(s)]
  double gyro_bias_radps = 0.0;     ///< turn-on bias, 1 sigma
  double accel_bias_mps2 = 0.0;     ///< turn-on bias, 1 sigma
  double gyro_bias_rw = 0.0;        ///< wander of the bias [rad/s/sqrt(s)]
  double accel_bias_rw = 0.0;       ///< wander of the bias [m/s^2/sqrt(s)]
  double gyro_scale = 0.0;          ///< 1 sigma
  double accel_scale = 0.0;         ///< 1 sigma
  double gyro_misalignment = 0.0;   ///< cross-axis share [rad], 1 sigma: what a turn about one axis
                                    ///< shows on another and no state takes up
  double accel_misalignment = 0.0;  ///< the same of accelerations
  double gyro_range_radps = 35.0;   ///< beyond it a sample is a spike
  double accel_range_mps2 = 160.0;
};

struct SensorProfile {
  std::string_view name;
  std::string_view about;  ///< one line for --help: which units
  ImuNoise noise;
};

/// "ahrs400cc-100", "consumer-mems", "industrial-mems".
std::span<const SensorProfile> SensorProfiles();
std::optional<ImuNoise> FindSensorProfile(std::string_view name);

}  // namespace kawara::estimation
