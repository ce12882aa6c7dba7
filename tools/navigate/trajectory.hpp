#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "core/expected.hpp"
#include "estimation/nav_types.hpp"
#include "tools/navigate/safe_file.hpp"

namespace kawara::navigate {

/// What traj.csv keeps of a solution: small, because a smoothed run holds all of them.
struct TrajectoryPoint {
  core::GpsTime time;
  core::Geodetic position;
  Eigen::Vector3d velocity_ned_mps;
  core::Attitude attitude;
  Eigen::Vector3d position_sd_ned_m;
  Eigen::Vector3d velocity_sd_ned_mps;
  Eigen::Vector3d attitude_sd_rad;
  estimation::NavState state;
  estimation::NavReason reason;

  static TrajectoryPoint Of(const estimation::NavSolution& solution);
};

/// traj.csv: t [s, as the input counts them, on the GNSS time scale], lat, lon [deg], h [m], vN,
/// vE, vD [m/s], roll, pitch, yaw [deg, yaw 0..360], their standard deviations, state, reason.
class TrajectoryFile {
 public:
  static core::Expected<TrajectoryFile> Create(const std::string& path);
  core::Expected<void> Add(const TrajectoryPoint& point);
  core::Expected<void> Commit() { return file_.Commit(); }
  std::int64_t rows() const { return rows_; }

 private:
  explicit TrajectoryFile(SafeFile file) : file_(std::move(file)) {}
  SafeFile file_;
  std::string line_;
  std::int64_t rows_ = 0;
};

}  // namespace kawara::navigate
