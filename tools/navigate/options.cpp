#include "tools/navigate/options.hpp"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "core/config/config.hpp"
#include "estimation/sensor_figures.hpp"

namespace kawara::navigate {
namespace {

std::string ProfilesHelp() {
  std::string text = std::string("Inertial unit (") + kDefaultSensor + ", or the log's):";
  for (const estimation::SensorProfile& profile : estimation::SensorProfiles()) {
    text += "\n" + std::string(profile.name) + ": " + std::string(profile.about);
  }
  text += "\nor FILE.yaml: a 'profile' and Allan figures in place of its, of ";
  core::config::KeyLister figures;
  estimation::SensorFigures().Visit(figures);
  for (const char* key : figures.keys)
    text += (key == figures.keys.front() ? "" : ", ") + std::string(key);
  return text;
}

core::Expected<Eigen::Vector3d> ParseLever(const std::string& text) {
  Eigen::Vector3d lever;
  const char* at = text.data();
  const char* const end = at + text.size();
  bool good = true;
  for (int i = 0; i < 3 && good; ++i) {
    const auto [next, error] = std::from_chars(at, end, lever[i]);
    good = error == std::errc() && (i == 2 ? next == end : next != end && *next == ',');
    at = next + (i == 2 ? 0 : 1);
  }
  constexpr double kLongest = 100.0;
  if (good && lever.allFinite() && lever.norm() < kLongest) return lever;
  return core::Fail(core::ErrorCode::kInvalidArgument,
                    "--lever '" + text +
                        "': expected the antenna seen from the IMU, forward, right and down in "
                        "metres, as in 0.12,-0.18,-0.92");
}

/// A profile's name, or a file of figures.
core::Expected<estimation::ImuNoise> SensorOf(const std::string& sensor) {
  if (const auto noise = estimation::FindSensorProfile(sensor)) return *noise;
  const std::string ending = std::filesystem::path(sensor).extension().string();
  if (ending == ".yaml" || ending == ".yml") {
    const auto file = core::config::Load<estimation::SensorFile>(sensor);
    if (!file) return tl::unexpected(file.error());
    // The schema lets only known names through.
    const auto profile = estimation::FindSensorProfile(file->profile);
    return estimation::WithFigures(profile.value_or(estimation::ImuNoise{}), file->figures);
  }
  std::string names;
  for (const estimation::SensorProfile& profile : estimation::SensorProfiles()) {
    names += std::string(profile.name) + ", ";
  }
  return core::Fail(core::ErrorCode::kInvalidArgument,
                    "--sensor '" + sensor + "': no such profile; there are: " + names +
                        "and FILE.yaml with figures of its own");
}

}  // namespace

void AddOptions(CLI::App& app, Options& o) {
  app.add_option("LOG", o.logs,
                 "Logs of kawara-onboard, files or folders, instead of --imu and --gnss: GNSS, "
                 "inertial samples and the unit's attitude as the robot received them");
  app.add_option("--config", o.config, "The robot's configuration instead of the one in the log");
  app.add_option("--imu", o.imu,
                 "CSV: t, wx, wy, wz [rad/s], ax, ay, az [m/s^2], forward-right-down");
  app.add_option(
      "--gnss", o.aids.gnss,
      "CSV: t, lat, lon [deg], h [m], q (1 fixed, 2 float, 5 single, ...), and if there: "
      "sdN, sdE, sdD, nsat, vN, vE, vD, sdvN, sdvE, sdvD, heading, sd_heading, t_rx");
  app.add_option("--odo", o.aids.odometry, "CSV of wheels: t, vx [m/s], and if there wz [rad/s]");
  app.add_option("--attitude", o.aids.attitude,
                 "CSV of the unit's own attitude: t, roll, pitch, and if there yaw [deg]");
  app.add_option("--blank", o.withheld.blank,
                 "CSV of t_start, t_end: no GNSS in there; scored against its RTK fixed positions");
  app.add_option("--blank-run", o.withheld.blank_run,
                 "Only the windows whose column 'run' is this");
  app.add_option("--hold-out", o.withheld.hold_out,
                 "CSV of epochs t: withheld from the filter, scored at the end");
  app.add_option("--sensor", o.sensor, ProfilesHelp());
  app.add_option("--lever", o.lever,
                 "Antenna seen from the IMU [m]: forward,right,down (0,0,0, or the log's)");
  app.add_option("--at", o.at, "Whose trajectory: imu or antenna")->capture_default_str();
  app.add_option("--constraint", o.constraint,
                 "auto: a vehicle, which moves neither sideways nor up as far as that proves true; "
                 "off: carried, flying, sailing")
      ->capture_default_str();
  app.add_flag("--smooth", o.smooth, "The smoothed trajectory, from the data of all times");
  app.add_flag("--use-arrival-times", o.aids.use_arrival_times,
               "GNSS is handed over at t_rx, as a robot got it; otherwise at its epoch");
  app.add_option("--plot", o.plot, "Report with pictures, one HTML file that needs nothing else");
  app.add_flag("--json", o.json, "The table at the end as one JSON object");
  app.add_option("--out", o.out, "The trajectory, CSV")->required();
}

core::Expected<RunOptions> RunOptionsOf(const Options& options) {
  const auto wrong = [](const std::string& message) {
    return core::Fail(core::ErrorCode::kInvalidArgument, message);
  };
  RunOptions run;
  const auto noise = SensorOf(options.sensor.empty() ? kDefaultSensor : options.sensor);
  if (!noise) return tl::unexpected(noise.error());
  run.navigation.imu = *noise;
  if (!options.lever.empty()) {
    const auto lever = ParseLever(options.lever);
    if (!lever) return tl::unexpected(lever.error());
    run.navigation.lever_arm_frd_m = *lever;
  }
  if (options.logs.empty() && (options.imu.empty() || options.aids.gnss.empty())) {
    return wrong(
        "nothing to read: give --imu and --gnss, or a log of the robot (--help tells more)");
  }
  if (!options.logs.empty() &&
      !(options.imu + options.aids.gnss + options.aids.odometry + options.aids.attitude).empty()) {
    return wrong("a log and CSV files: one or the other");
  }
  if (options.logs.empty() && !options.config.empty()) {
    return wrong("--config is the configuration of a log's robot, and there is no log");
  }
  if (options.at != "imu" && options.at != "antenna") {
    return wrong("--at '" + options.at + "': expected imu or antenna");
  }
  if (options.constraint != "auto" && options.constraint != "off") {
    return wrong("--constraint '" + options.constraint + "': expected auto or off");
  }
  if (options.withheld.blank_run && options.withheld.blank.empty()) {
    return wrong("--blank-run without --blank: name the file of the windows");
  }
  run.at_antenna = options.at == "antenna";
  run.navigation.constraint = options.constraint == "off" ? estimation::ConstraintMode::kOff
                                                          : estimation::ConstraintMode::kAuto;
  run.smooth = options.smooth;
  run.plot = !options.plot.empty();
  return run;
}

}  // namespace kawara::navigate
