#pragma once
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "tools/navigate/aids.hpp"
#include "tools/navigate/navigation_run.hpp"

namespace CLI {
class App;
}

namespace kawara::navigate {

/// The command line.
struct Options {
  std::vector<std::string> logs;
  std::string config;  ///< of a log's robot
  std::string imu;
  AidFiles aids;
  WithheldFiles withheld;
  std::string sensor;
  std::string lever;
  std::string at = "imu";
  std::string constraint = "auto";
  bool smooth = false;
  bool json = false;
  std::string plot;
  std::string out;
};

inline constexpr const char* kDefaultSensor = "ahrs400cc-100";

void AddOptions(CLI::App& app, Options& options);

/// What the words mean; where neither sensor nor lever arm is given, those of kDefaultSensor and
/// zero: a log may know better. Errors: kInvalidArgument, one line (an unknown profile is answered
/// with those there are).
core::Expected<RunOptions> RunOptionsOf(const Options& options);

}  // namespace kawara::navigate
