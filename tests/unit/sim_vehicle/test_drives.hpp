#pragma once
#include <cmath>

#include "sim/vehicle/trajectory.hpp"

/// Vehicles and ways that several tests of this folder drive.
namespace kawara::sim {

inline const core::Geodetic kOrigin{35.71 * core::kRadFromDeg, 139.76 * core::kRadFromDeg, 60.0};
inline const core::GpsTime kBegin =
    core::FromWeek({.week = 2391, .time_of_week = core::Seconds(7200)});

/// Slopes, a hump and ripples.
inline double Hills(double east_m, double north_m) {
  return 0.03 * east_m - 0.02 * north_m + 0.3 * std::sin(east_m / 7.0) * std::cos(north_m / 5.0);
}

inline VehicleConfig Robot() {
  VehicleConfig robot;
  robot.turning_point_forward_m = -0.05;
  return robot;
}

inline VehicleConfig Car() {
  VehicleConfig car;
  car.kind = VehicleKind::kCarLike;
  car.wheelbase_m = 2.6;
  car.track_m = 1.5;
  car.min_turning_radius_m = 4.5;
  car.corner_radius_m = 6.0;
  car.turning_point_forward_m = -1.3;
  car.reference_height_m = 0.5;
  car.limits = {.acceleration_mps2 = 1.5,
                .deceleration_mps2 = 2.0,
                .lateral_mps2 = 2.0,
                .jerk_mps3 = 4.0,
                .turn_rate_degps = 40.0,
                .turn_acceleration_degps2 = 80.0};
  car.vibration.natural_hz = 1.4;
  car.vibration.reference_speed_mps = 10.0;
  return car;
}

/// A corner driven through, one turned on the spot after a stop, a reversal, about 70 m.
inline PathConfig RobotPath() {
  PathConfig path;
  path.waypoints = {
      {0, 0, {}, 0}, {20, 0, {}, 0}, {20, 15, 1.2, 2.0}, {5, 20, {}, 0}, {14, 20, {}, 0}};
  return path;
}

inline PathConfig CarPath() {
  PathConfig path;
  path.waypoints = {{0, 0, {}, 0}, {60, 5, {}, 0}, {70, 60, 5.0, 3.0}, {10, 80, {}, 0}};
  path.speed_mps = 8.0;
  return path;
}

}  // namespace kawara::sim
