#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "core/time.hpp"
#include "sim/vehicle/gnss_model.hpp"
#include "sim/vehicle/magnetometer.hpp"
#include "sim/vehicle/measured_drive.hpp"
#include "sim/vehicle/odometry.hpp"
#include "sim/vehicle/sensor_config.hpp"
#include "sim/vehicle/trajectory.hpp"
#include "sim/vehicle/vehicle_config.hpp"

namespace kawara::sim {

/// What the site does to motion and sensors. Each may be left empty: level ground, open sky, no
/// iron. Asked during SimulateDrive() only.
struct Surroundings {
  GroundHeight ground_height_m;
  SkyBlocked blocked;
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
