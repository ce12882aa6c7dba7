#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/config/constraints.hpp"

/// Schema of a simulated vehicle and of the path it takes (configs/vehicles/*.yaml): defaults,
/// units in the keys, ranges. The sensors' errors are in sensor_config.hpp.
namespace kawara::sim {

namespace config = core::config;

enum class VehicleKind : std::uint8_t {
  kSkidSteer,  ///< tracks or fixed wheels: turns on the spot
  kCarLike,    ///< front wheels steer: never below the minimum turning radius
};
constexpr auto ConfigNames(VehicleKind /*tag*/) {
  return std::array{config::EnumName<VehicleKind>{VehicleKind::kSkidSteer, "skid-steer"},
                    config::EnumName<VehicleKind>{VehicleKind::kCarLike, "car-like"}};
}

/// What the driver keeps to in the plane (vibration comes on top); across, up to a fifth more where
/// a curve begins.
struct MotionLimits {
  double acceleration_mps2 = 0.5;
  double deceleration_mps2 = 0.6;
  double lateral_mps2 = 0.5;
  double jerk_mps3 = 2.0;
  double turn_rate_degps = 35.0;  ///< on the spot and in curves
  double turn_acceleration_degps2 = 60.0;

  template <class V>
  void Visit(V& v) {
    v("acceleration_mps2", acceleration_mps2, config::Range{0.05, 10.0}, config::Optional{});
    v("deceleration_mps2", deceleration_mps2, config::Range{0.05, 10.0}, config::Optional{});
    v("lateral_mps2", lateral_mps2, config::Range{0.05, 10.0}, config::Optional{});
    v("jerk_mps3", jerk_mps3, config::Range{0.1, 100.0}, config::Optional{});
    v("turn_rate_degps", turn_rate_degps, config::Range{1.0, 180.0}, config::Optional{});
    v("turn_acceleration_degps2", turn_acceleration_degps2, config::Range{1.0, 720.0},
      config::Optional{});
  }
};

/// Shaking of the body about the ground's own shape: a road whose unevenness falls with frequency,
/// through a suspension with one resonance. Size at the reference speed; it goes with
/// (speed / reference)^exponent and never below the motors' idle share.
struct VibrationConfig {
  double roll_rms_deg = 0.25;
  double pitch_rms_deg = 0.3;
  double heave_rms_m = 0.002;
  double reference_speed_mps = 1.0;
  double speed_exponent = 0.7;
  double idle_share = 0.01;  ///< of the above while standing
  double natural_hz = 4.0;   ///< of the suspension (a robot's tyres: 3..6, a car: 1..1.5)
  double damping = 0.3;      ///< of critical
  double min_hz = 0.7;
  double max_hz = 16.0;

  template <class V>
  void Visit(V& v) {
    v("roll_rms_deg", roll_rms_deg, config::Range{0.0, 5.0}, config::Optional{});
    v("pitch_rms_deg", pitch_rms_deg, config::Range{0.0, 5.0}, config::Optional{});
    v("heave_rms_m", heave_rms_m, config::Range{0.0, 0.1}, config::Optional{});
    v("reference_speed_mps", reference_speed_mps, config::Range{0.05, 50.0}, config::Optional{});
    v("speed_exponent", speed_exponent, config::Range{0.1, 3.0}, config::Optional{});
    v("idle_share", idle_share, config::Range{0.0, 1.0}, config::Optional{});
    v("natural_hz", natural_hz, config::Range{0.2, 50.0}, config::Optional{});
    v("damping", damping, config::Range{0.02, 2.0}, config::Optional{});
    v("min_hz", min_hz, config::Range{0.1, 50.0}, config::Optional{});
    v("max_hz", max_hz, config::Range{0.2, 50.0}, config::Optional{});
    v.Require(max_hz > min_hz, "max_hz", "more than min_hz");
  }
};

/// A laser scanner's place; its right-to-left sweep lies in the plane of the mount's x and y axes.
struct ScannerMount {
  std::string name;                                              ///< "laser1": names the port too
  Eigen::Vector3d position_frd_m = Eigen::Vector3d::Zero();      ///< from the reference point
  Eigen::Vector3d roll_pitch_yaw_deg = Eigen::Vector3d::Zero();  ///< body to mount, ZYX, FRD axes

  template <class V>
  void Visit(V& v) {
    v("name", name, config::NotEmpty{});
    v("position_frd_m", position_frd_m, config::Range{-20.0, 20.0});
    v("roll_pitch_yaw_deg", roll_pitch_yaw_deg, config::Range{-180.0, 180.0}, config::Optional{});
  }
};

/// The body. Its reference point lies on the middle line between the wheels, reference_height_m
/// above the ground, halfway between the axles; all lever arms are forward, right, down from it.
struct VehicleConfig {
  VehicleKind kind = VehicleKind::kSkidSteer;
  double wheelbase_m = 0.6;
  double track_m = 0.5;
  double min_turning_radius_m = 0.0;  ///< of the turning point; skid-steer: 0
  double corner_radius_m = 0.6;       ///< wished at waypoints driven through
  /// The point of the middle line that follows the path and does not slip sideways, forward of the
  /// reference point. Car: the rear axle, -wheelbase/2. Skid-steer: where its weight puts it.
  double turning_point_forward_m = 0.0;
  double reference_height_m = 0.25;
  double suspension_s = 0.1;  ///< over which tyres and springs smooth the ground's steps
  MotionLimits limits;
  VibrationConfig vibration;
  Eigen::Vector3d antenna_frd_m{-0.1, 0.0, -1.1};
  Eigen::Vector3d ahrs_frd_m{0.1, 0.0, -0.1};
  Eigen::Vector3d camera_frd_m{0.0, 0.0, -0.9};
  std::vector<ScannerMount> scanners;

  template <class V>
  void Visit(V& v) {
    v("kind", kind);
    v("wheelbase_m", wheelbase_m, config::Range{0.1, 10.0});
    v("track_m", track_m, config::Range{0.1, 5.0});
    v("min_turning_radius_m", min_turning_radius_m, config::Range{0.0, 50.0}, config::Optional{});
    v("corner_radius_m", corner_radius_m, config::Range{0.2, 100.0}, config::Optional{});
    v("turning_point_forward_m", turning_point_forward_m, config::Range{-5.0, 5.0},
      config::Optional{});
    v("reference_height_m", reference_height_m, config::Range{0.0, 5.0}, config::Optional{});
    v("suspension_s", suspension_s, config::Range{0.04, 1.0}, config::Optional{});
    v("limits", limits, config::Optional{});
    v("vibration", vibration, config::Optional{});
    v("antenna_frd_m", antenna_frd_m, config::Range{-20.0, 20.0});
    v("ahrs_frd_m", ahrs_frd_m, config::Range{-20.0, 20.0});
    v("camera_frd_m", camera_frd_m, config::Range{-20.0, 20.0});
    v("scanners", scanners, config::Optional{});
    v.Require(kind == VehicleKind::kSkidSteer || min_turning_radius_m > 0.0, "min_turning_radius_m",
              "above 0 for a car-like vehicle");
  }
};

/// A corner of the path in the site's ENU.
struct Waypoint {
  double east_m = 0.0;
  double north_m = 0.0;
  std::optional<double> speed_mps;  ///< from here on; else as before
  double stop_s = 0.0;              ///< stands here; skid-steer then turns on the spot

  template <class V>
  void Visit(V& v) {
    v("east_m", east_m, config::Range{-1e5, 1e5});
    v("north_m", north_m, config::Range{-1e5, 1e5});
    v("speed_mps", speed_mps, config::Range{0.05, 40.0}, config::Optional{});
    v("stop_s", stop_s, config::Range{0.0, 3600.0}, config::Optional{});
  }
};

struct PathConfig {
  std::vector<Waypoint> waypoints;  ///< two or more
  double speed_mps = 0.8;
  double stand_before_s = 10.0;  ///< for alignment
  double stand_after_s = 3.0;

  template <class V>
  void Visit(V& v) {
    v("waypoints", waypoints, config::NotEmpty{});
    v("speed_mps", speed_mps, config::Range{0.05, 40.0});
    v("stand_before_s", stand_before_s, config::Range{1.0, 3600.0}, config::Optional{});
    v("stand_after_s", stand_after_s, config::Range{1.0, 3600.0}, config::Optional{});
    v.Require(waypoints.size() >= 2, "waypoints", "two or more");
  }
};

}  // namespace kawara::sim
