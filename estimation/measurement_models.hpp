#pragma once
#include <Eigen/Core>

#include "core/measurements.hpp"
#include "estimation/error_state_filter.hpp"
#include "estimation/nav_types.hpp"
#include "estimation/navigation_config.hpp"

/// Each measurement against a nominal state, linearised: pure functions.
namespace kawara::estimation {

/// How the body moves at the instant of the measurement, corrected.
struct BodyMotion {
  Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();         ///< body
  Eigen::Vector3d acceleration_mps2 = Eigen::Vector3d::Zero();  ///< NED, without gravity
};

/// GNSS positions come in three kinds; each has errors of its own.
enum class GnssGrade : std::uint8_t { kFixed, kFloat, kCode };
GnssGrade GradeOf(core::RtkState rtk);

/// Stated variance, north, east, down [m^2], with the floor.
Eigen::Vector3d StatedVarianceNed(const core::GnssFix& fix, const GnssErrors& errors);
/// How the stated variance divides up.
struct ColouredShare {
  double white = 1.0;     ///< of the standard deviation
  double coloured = 0.0;  ///< of the standard deviation
  double time_s = 1.0;    ///< the coloured part lasts this long
};
ColouredShare ShareOf(GnssGrade grade, const GnssErrors& errors);

/// `shift_s`: the fix's epoch minus the stamp at which the filter stands; the offset of the IMU's
/// clock should be that, and what it is not moves the antenna along its path.
MeasurementRows PositionRows(const NominalState& state, const BodyMotion& motion,
                             const core::GnssFix& fix, double shift_s,
                             const NavigationConfig& config);
MeasurementRows GnssVelocityRows(const NominalState& state, const BodyMotion& motion,
                                 const core::GnssFix& fix, double shift_s,
                                 const NavigationConfig& config);
/// True heading by two antennas, along body x.
MeasurementRows HeadingRows(const NominalState& state, double heading_rad, double sd_rad);
/// Magnetic heading: with its lasting error.
MeasurementRows AhrsHeadingRows(const NominalState& state, double heading_rad, double sd_rad);
MeasurementRows LevelRows(const NominalState& state, const core::Attitude& attitude, double sd_rad);

/// Velocity of the axle point in the vehicle's axes, forward, right, down [m/s].
Eigen::Vector3d VehicleVelocity(const NominalState& state, const BodyMotion& motion);
MeasurementRows SpeedRows(const NominalState& state, const BodyMotion& motion, double speed_mps,
                          double sd_mps);
/// Nothing sideways, nothing upwards; one standard deviation each.
MeasurementRows ConstraintRows(const NominalState& state, const BodyMotion& motion,
                               double right_sd_mps, double down_sd_mps);
MeasurementRows TurnRateRows(const NominalState& state, const Eigen::Vector3d& measured_rate_radps,
                             double turn_rate_radps, double sd_radps);

MeasurementRows ZeroVelocityRows(const NominalState& state, double sd_mps);
/// The gyros at rest show their bias and the turning Earth. `measured_radps`: mean over the rest.
MeasurementRows ZeroRateRows(const NominalState& state, const Eigen::Vector3d& measured_radps,
                             double sd_radps);

}  // namespace kawara::estimation
