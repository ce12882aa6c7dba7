#pragma once
#include <cstdint>
#include <vector>

#include "core/time.hpp"
#include "sim/vehicle/sensor_config.hpp"
#include "sim/vehicle/trajectory.hpp"
#include "sim/vehicle/vehicle_config.hpp"

namespace kawara::sim {

/// One reading of the wheel encoders.
struct OdometrySample {
  core::GpsTime time;   ///< true instant
  core::GpsTime stamp;  ///< by the instrument's own clock
  std::int64_t left_ticks = 0;
  std::int64_t right_ticks = 0;
  double left_mps = 0.0;  ///< measured mean speeds since the reading before
  double right_mps = 0.0;
  double true_left_m = 0.0;  ///< way over ground of each side's wheel since the start
  double true_right_m = 0.0;
  bool slipping = false;  ///< a burst or a skid is on
};

/// The whole drive as the wheel encoders of each side (a skid-steer's tracks, a car's rear wheels)
/// count it: way over ground at the turning point's axle, turned by wheels that are not quite as
/// large as stated, slip all the time a little (more in turns), and now and then spin or lock.
/// Ticks are whole; what is lost by rounding comes with the next reading.
std::vector<OdometrySample> MeasureOdometry(const Trajectory& trajectory,
                                            const VehicleConfig& vehicle,
                                            const OdometryConfig& config, std::uint64_t seed);

}  // namespace kawara::sim
