#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/geodesy.hpp"
#include "core/time.hpp"

/// What the filter estimates: the nominal state, and the order of its errors.
namespace kawara::estimation {

constexpr int kErrorStates = 36;
using ErrorVector = Eigen::Matrix<double, kErrorStates, 1>;
using ErrorCovariance = Eigen::Matrix<double, kErrorStates, kErrorStates>;

/// First index of each error. "Error" is what has to be ADDED to the nominal value; that of the
/// attitude is the rotation vector in NED to be put in front of it.
enum ErrorIndex : int {
  kPosition = 0,        ///< north, east, down [m]
  kVelocity = 3,        ///< north, east, down [m/s]
  kAttitude = 6,        ///< about north, east, down [rad]
  kGyroBias = 9,        ///< [rad/s]
  kAccelBias = 12,      ///< [m/s^2]
  kGyroScale = 15,      ///< [1]
  kAccelScale = 18,     ///< [1]
  kGnssColoured = 21,   ///< lasting error of GNSS positions, north, east, down [m]
  kTimeOffset = 24,     ///< GNSS time minus IMU stamp [s]
  kVelocityDelay = 25,  ///< GNSS velocity is that of so long before its epoch [s]
  kSpeedScale = 26,     ///< wheels say (1 + scale) x speed
  kTurnScale = 27,      ///< wheels say (1 + scale) x turn rate
  kMountPitch = 28,     ///< vehicle axes against IMU axes [rad]
  kMountYaw = 29,
  kAxle = 30,         ///< the point that does not slide sideways, forward of the IMU [m]
  kAhrsHeading = 31,  ///< lasting error of the magnetic heading [rad]
  kSquat = 32,        ///< a sprung body pitches under forward acceleration [rad per m/s^2]
  kSideslip = 33,     ///< tyres slip sideways under lateral acceleration [rad per m/s^2]
  kGyroCross = 34,    ///< what a turn about z shows about x and y [1]
};

struct NominalState {
  core::GpsTime stamp;  ///< as the IMU counts it
  core::Geodetic position;
  Eigen::Vector3d velocity_ned_mps = Eigen::Vector3d::Zero();
  Eigen::Quaterniond ned_from_body = Eigen::Quaterniond::Identity();
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias_mps2 = Eigen::Vector3d::Zero();
  Eigen::Vector3d gyro_scale = Eigen::Vector3d::Zero();   ///< measured = (1 + scale) x true + bias
  Eigen::Vector3d accel_scale = Eigen::Vector3d::Zero();  ///< the same
  Eigen::Vector3d gnss_coloured_ned_m = Eigen::Vector3d::Zero();
  double time_offset_s = 0.0;
  double velocity_delay_s = 0.0;
  double speed_scale = 0.0;
  double turn_scale = 0.0;
  double mount_pitch_rad = 0.0;
  double mount_yaw_rad = 0.0;
  double axle_m = 0.0;
  double ahrs_heading_rad = 0.0;
  double squat_rad_per_mps2 = 0.0;
  double sideslip_rad_per_mps2 = 0.0;
  Eigen::Vector2d gyro_cross = Eigen::Vector2d::Zero();  ///< vehicles turn about z, most of all

  Eigen::Vector3d TrueRate(const Eigen::Vector3d& measured_radps) const {
    Eigen::Vector3d rate =
        (measured_radps - gyro_bias_radps).cwiseQuotient(Eigen::Vector3d::Ones() + gyro_scale);
    rate.head<2>() -= gyro_cross * rate.z();
    return rate;
  }
  Eigen::Vector3d TrueForce(const Eigen::Vector3d& measured_mps2) const {
    return (measured_mps2 - accel_bias_mps2).cwiseQuotient(Eigen::Vector3d::Ones() + accel_scale);
  }
  /// Adds an estimated error.
  void Correct(const ErrorVector& error);
};

/// Position moved by a small north, east, down [m] along the ellipsoid (metres, not kilometres).
core::Geodetic Displaced(const core::Geodetic& from, const Eigen::Vector3d& ned_m);
/// Small difference to - from, the inverse of Displaced.
Eigen::Vector3d Displacement(const core::Geodetic& from, const core::Geodetic& to);

}  // namespace kawara::estimation
