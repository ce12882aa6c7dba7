#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <memory>

#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "core/time.hpp"
#include "sim/vehicle/vehicle_config.hpp"

namespace kawara::sim {

/// Height of the ground [m] of the site's ENU at east, north [m].
using GroundHeight = std::function<double(double east_m, double north_m)>;

/// The vehicle's motion at one instant, exactly: every derivative belongs to the one above it.
/// World: the site's ENU (a plane tangent at its origin, turning with the Earth). Body: forward,
/// right, down at the reference point.
struct MotionState {
  Eigen::Vector3d position_enu_m = Eigen::Vector3d::Zero();  ///< of the reference point
  Eigen::Vector3d velocity_enu_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration_enu_mps2 = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R_enu_body = Eigen::Matrix3d::Identity();
  core::Attitude attitude;  ///< against north, east, down AT THE ORIGIN
  Eigen::Vector3d rate_body_radps = Eigen::Vector3d::Zero();  ///< against the ENU axes, body axes
  Eigen::Vector3d rate_dot_body_radps2 = Eigen::Vector3d::Zero();

  /// Of a point of the body at lever arm forward, right, down.
  Eigen::Vector3d PointEnu(const Eigen::Vector3d& lever_frd_m) const {
    return position_enu_m + R_enu_body * lever_frd_m;
  }
  Eigen::Vector3d PointVelocityEnu(const Eigen::Vector3d& lever_frd_m) const {
    return velocity_enu_mps + R_enu_body * rate_body_radps.cross(lever_frd_m);
  }
  Eigen::Vector3d PointAccelerationEnu(const Eigen::Vector3d& lever_frd_m) const {
    return acceleration_enu_mps2 +
           R_enu_body * (rate_dot_body_radps2.cross(lever_frd_m) +
                         rate_body_radps.cross(rate_body_radps.cross(lever_frd_m)));
  }
};

/// Where the vehicle is and how it moves at ANY time: path, speed, ground and vibration joined into
/// one motion that is three times continuously differentiable, so that simulated inertial data
/// integrate back to it. The turning point follows the path without side slip; corners are rounded;
/// starts, stops and turns on the spot are smooth; before begin() and after end() it stands.
///
/// How: plan path, way along it, turns, and ground under the wheels are uniform quintic B-splines
/// (SmoothSeries) over finely sampled raw values, which smooths without overshoot; vibration is a
/// sum of sines whose size is such a spline. Immutable, cheap to copy, any thread.
class Trajectory {
 public:
  /// `ground` is asked during Make() only; empty: level ground at 0. Errors: kInvalidArgument,
  /// which waypoint and why (too sharp for the turning radius, on top of another).
  static core::Expected<Trajectory> Make(const VehicleConfig& vehicle, const PathConfig& path,
                                         const core::Geodetic& origin, core::GpsTime begin,
                                         const GroundHeight& ground, std::uint64_t seed);

  core::GpsTime begin() const;
  core::GpsTime end() const;  ///< stand_after_s after the last stop
  const core::Geodetic& origin() const;

  MotionState At(core::GpsTime t) const { return AtSeconds(core::ToSeconds(t - begin())); }
  /// Seconds after begin(), for formulas.
  MotionState AtSeconds(double since_begin_s) const;

  core::Geodetic GeodeticAt(core::GpsTime t, const Eigen::Vector3d& lever_frd_m) const;
  /// Attitude against north, east, down at the vehicle's own place: yaw is TRUE heading there.
  core::Attitude AttitudeAt(core::GpsTime t) const;
  /// Turns vectors of the site's ENU into north, east, down at a place.
  Eigen::Matrix3d RotationNedFromEnu(const core::Geodetic& place) const;

 private:
  struct Parts;
  explicit Trajectory(std::shared_ptr<const Parts> parts) : parts_(std::move(parts)) {}
  std::shared_ptr<const Parts> parts_;
};

}  // namespace kawara::sim
