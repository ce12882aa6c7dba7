#pragma once
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "estimation/nav_types.hpp"
#include "estimation/navigation_config.hpp"
#include "tools/navigate/aids.hpp"
#include "tools/navigate/sensor_files.hpp"

namespace kawara::navigate {

/// What a robot's log holds for the navigation filter, decoded anew from the recorded bytes by the
/// robot's own core, so on the time line that the robot had. Times of the week as the files have
/// them (all weeks land in one).
struct LogRecording {
  std::vector<estimation::ImuSample> imu;
  /// `received` lies between the inertial samples that the epoch came between.
  std::vector<GnssRow> gnss;
  std::vector<Aid> attitudes;
  estimation::NavigationConfig navigation;  ///< as the robot was configured
  std::vector<std::string> remarks;         ///< damage of the log
};

/// Reads LCM logs (files or folders) of kawara-onboard. The configuration is that of the log, or
/// `config_path` if that is not empty. Errors: those of EventLogReader and of the configuration;
/// kFormat if there are no dated inertial samples.
core::Expected<LogRecording> ReadLog(const std::vector<std::string>& paths,
                                     const std::string& config_path);

}  // namespace kawara::navigate
