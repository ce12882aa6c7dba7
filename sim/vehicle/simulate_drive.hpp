#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "core/time.hpp"
#include "sim/vehicle/gnss_config.hpp"
#include "sim/vehicle/measured_drive.hpp"
#include "sim/vehicle/sensor_config.hpp"
#include "sim/vehicle/trajectory.hpp"
#include "sim/vehicle/vehicle_config.hpp"

namespace kawara::sim {

/// Iron that bends the compass: a magnetic dipole standing at the site.
struct SteelObject {
  Eigen::Vector3d position_enu_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment_enu_am2 = Eigen::Vector3d::Zero();  ///< a car: some 100 A m^2, downwards
};

/// What the site does to motion and sensors. Each may be left empty: level ground, open sky, no
/// iron. Asked during SimulateDrive() only.
struct Surroundings {
  GroundHeight ground_height_m;
  /// Whether something stands between a point [ENU, m] and the sky at azimuth (true, clockwise from
  /// north) and elevation [rad].
  std::function<bool(const Eigen::Vector3d& enu_m, double azimuth_rad, double elevation_rad)>
      blocked;
  std::vector<SteelObject> steel;
};

struct SensorsConfig {
  ImuConfig imu = ImuConfig::Named("ahrs400cc-100");
  MagnetometerConfig magnetometer = MagnetometerConfig::Named("on-robot");
  GnssConfig gnss = GnssConfig::Named("z-xtreme");
  OdometryConfig odometry = OdometryConfig::Named("skid-steer");

  template <class V>
  void Visit(V& v) {
    v("imu", imu, config::Optional{});
    v("magnetometer", magnetometer, config::Optional{});
    v("gnss", gnss, config::Optional{});
    v("odometry", odometry, config::Optional{});
  }
};

/// A vehicle with its sensors: one file (configs/vehicles/*.yaml).
struct RobotModel {
  VehicleConfig vehicle;
  SensorsConfig sensors;

  template <class V>
  void Visit(V& v) {
    v("vehicle", vehicle);
    v("sensors", sensors, config::Optional{});
  }
};

/// Everything that decides a simulated drive; together with the surroundings, byte for byte.
struct DriveScenario {
  core::Geodetic origin;  ///< of the site's ENU
  core::GpsTime begin;    ///< whole seconds, so that epochs lie on the receiver's grid
  RobotModel robot;
  PathConfig path;
  std::uint64_t seed = 1;
};

/// What the receiver did at an epoch, and how far off it was.
struct GnssEpochTruth {
  core::GpsTime time;
  core::RtkState rtk = core::RtkState::kNone;
  bool wrong_fix = false;
  int satellites = 0;          ///< used
  double blocked_share = 0.0;  ///< of the sky's satellites above the mask
  double hdop = 0.0;
  double vdop = 0.0;
  core::Geodetic antenna;                                 ///< true
  Eigen::Vector3d error_ned_m = Eigen::Vector3d::Zero();  ///< of the fix; 0 without one
};

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

/// The inertial errors at one sample that wander; the drawn ones are in ImuErrors.
struct ImuBiasTruth {
  core::GpsTime time;
  Eigen::Vector3d gyro_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_mps2 = Eigen::Vector3d::Zero();
};

struct DriveTruth {
  Trajectory trajectory;
  std::vector<GnssEpochTruth> epochs;
  std::vector<OdometrySample> odometry;
  std::vector<ImuBiasTruth> biases;  ///< once a second
};

struct SimulatedDrive {
  Recording recording;  ///< what the instruments on the pseudo-terminals will send
  DriveTruth truth;
};

/// Drives the whole path in virtual time. recording.imu stamps are the end of each sample's
/// interval plus the unit's delay; recording.site.imu_late_s says how late that is on average (half
/// an interval plus the delay). Errors: kInvalidArgument of Trajectory::Make, or a drive longer
/// than a day.
core::Expected<SimulatedDrive> SimulateDrive(const DriveScenario& scenario,
                                             const Surroundings& surroundings = {});

}  // namespace kawara::sim
