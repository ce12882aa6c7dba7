#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "estimation/navigation_stats.hpp"
#include "tools/navigate/reference_errors.hpp"

namespace kawara::navigate {

/// An estimate and its standard deviation.
struct Found {
  double value = 0.0;
  double sd = 0.0;
};

/// What the filter found out about the sensors, at the end of the run.
struct CalibrationFound {
  Found time_offset_s;  ///< to be ADDED to IMU stamps to get GNSS time
  Found speed_scale;    ///< wheels say (1 + scale) x speed
  Found turn_scale;
  Found mount_pitch_deg;
  Found mount_yaw_deg;
  std::array<Found, 3> gyro_bias_degps;
  std::array<Found, 3> accel_bias_mps2;
};

/// Errors against what was withheld, by one solution.
struct ScoreSummary {
  ErrorSum held_out_fixed;
  ErrorSum held_out_float;
  std::int64_t held_out_uncovered = 0;
  std::vector<WindowError> windows;
};

/// Everything the table at the end says.
struct RunSummary {
  estimation::NavigationStats stats;
  std::optional<CalibrationFound> found;  ///< nothing if it never aligned, or not at the end
  bool wheels = false;                    ///< odometry was there
  bool scored = false;                    ///< something was held out or blanked
  ScoreSummary real_time;
  std::optional<ScoreSummary> smoothed;
  double imu_span_s = 0.0;
  std::optional<double> seconds_to_first_row;  ///< from the first inertial sample
  std::int64_t rows = 0;
  std::int64_t bad_rows = 0;  ///< of the input files
  double filter_s = 0.0;      ///< computing time of the navigator alone
  double smoother_s = 0.0;    ///< computing time
  double total_s = 0.0;       ///< wall time of the whole program
};

/// As a table for people.
std::string SummaryTable(const RunSummary& summary);
/// As one JSON object with a line end; what is unknown is null.
std::string SummaryJson(const RunSummary& summary);

}  // namespace kawara::navigate
