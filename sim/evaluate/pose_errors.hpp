#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "core/time.hpp"
#include "sim/evaluate/error_statistics.hpp"

namespace kawara::sim {

/// A pose as a table holds it. What a table has no column for is NaN or unset.
struct TablePose {
  core::GpsTime time;
  core::Geodetic position;
  std::optional<core::Attitude> attitude;
  Eigen::Vector3d sd_enu_m = Eigen::Vector3d::Constant(std::nan(""));  ///< as the result claims it
  std::string state;  ///< "fixed", ... or the number in the table
};

/// Reads a trajectory in order of time: a CSV file (columns gps_ns; lat_deg, lon_deg,
/// h_ellipsoidal_m or h_m; roll_deg, pitch_deg, yaw_deg if there are; with or without the prefix
/// "pose.", as kawara-log exports them) or the table obs_pose of a store. Rows without time or
/// place are left out. Errors: file, columns, no rows.
core::Expected<std::vector<TablePose>> ReadPoses(const std::string& path);

/// Position (east, north, up, horizontal, 3D [m]) and attitude (roll, pitch, yaw [deg]) of `result`
/// against the truth at the same instants, interpolated between rows at most `max_gap_s` apart;
/// and, where the result claims standard deviations, the squared horizontal error in units of them
/// (1 is honest). Poses the truth does not cover are counted, not judged. Errors: nothing overlaps.
core::Expected<ErrorReport> ComparePoses(const std::vector<TablePose>& truth,
                                         const std::vector<TablePose>& result,
                                         double max_gap_s = 0.5);

}  // namespace kawara::sim
