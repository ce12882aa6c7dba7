#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geodesy.hpp"
#include "core/measurements.hpp"
#include "core/time.hpp"

namespace kawara::sim {

/// One epoch of the recorded receiver; position of the ANTENNA.
struct RecordedFix {
  core::GpsTime time;
  core::Geodetic antenna;
  Eigen::Vector3d sd_ned_m = Eigen::Vector3d::Zero();
  core::RtkState rtk = core::RtkState::kNone;
  int satellites = 0;
  Eigen::Vector3d velocity_ned_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_sd_ned_mps = Eigen::Vector3d::Zero();
};

/// One recorded inertial sample; axes forward, right, down; at rest level the force is about (0, 0,
/// -9.8).
struct RecordedImu {
  core::GpsTime time;
  Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Zero();
  /// Empty where the recording has none: then it is made from the site's field (see MakeAhrsTrace).
  std::optional<Eigen::Vector3d> magnetic_gauss;
};

/// What the recording does not hold: see the README of the data folder for each value's standing.
struct RecordingSite {
  int gps_week = 0;
  double imu_late_s = 0.0;  ///< lateness of the IMU stamps against the fixes
  double geoid_m = 0.0;     ///< geoid above ellipsoid
  double declination_rad = 0.0;
  double dip_rad = 0.0;
  double field_gauss = 0.0;
};

/// A drive that was, or that SimulateDrive() made: fixes and samples in time order, at least two of
/// each, overlapping in time.
struct Recording {
  RecordingSite site;
  std::vector<RecordedFix> fixes;
  std::vector<RecordedImu> imu;

  core::GpsTime begin() const;  ///< first instant both streams cover
  core::GpsTime end() const;    ///< last instant both streams cover
  /// Moves everything in time, e.g. by whole seconds to "now".
  void Shift(core::Duration by);
};

}  // namespace kawara::sim
