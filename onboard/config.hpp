#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/config/constraints.hpp"
#include "estimation/sensor_figures.hpp"
#include "onboard/camera_config.hpp"
#include "onboard/epoch_scheduler.hpp"
#include "vision/phase1_picture.hpp"

/// Schema of a robot's YAML (configs/*.yaml): defaults, units in the keys, ranges. Loaded once by
/// main; a part sees only its own struct.
namespace kawara::onboard {

namespace config = core::config;

struct RobotConfig {
  std::string name = "robot1";
  std::string mission;  ///< empty: made from the start time, yyyymmddThhmmssZ

  template <class V>
  void Visit(V& v) {
    v("name", name, config::NotEmpty{});
    v("mission", mission, config::Optional{});
  }
};

/// The receiver's pulse at each full second, if a wire brings it to this computer.
struct PpsSettings {
  /// /dev/ppsN of the kernel, or a UNIX socket that tells the edges (kawara-sim); empty: none.
  std::string device;
  std::string edge = "rising";  ///< the one on the second; of the kernel's devices
  double stamp_sd_s = 20e-6;    ///< scatter of the stamps
  double latency_s = 0.0;       ///< from the edge to its stamp, known mean
  double latency_sd_s = 10e-6;  ///< how well that is known

  template <class V>
  void Visit(V& v) {
    v("device", device, config::Optional{});
    v("edge", edge, config::OneOf{"rising", "falling"}, config::Optional{});
    v("stamp_sd_s", stamp_sd_s, config::Range{1e-7, 0.1}, config::Optional{});
    v("latency_s", latency_s, config::Range{0.0, 0.1}, config::Optional{});
    v("latency_sd_s", latency_sd_s, config::Range{0.0, 0.1}, config::Optional{});
  }
};

struct GpsConfig {
  std::string device;
  int baud_bps = 115200;
  std::string profile = "ashtech-legacy";  ///< how the receiver encodes the RTK state
  bool configure = true;                   ///< send the receiver its set-up; false: take what comes
  double period_s = 0.1;                   ///< of epochs, asked of the receiver
  std::string data_port = "A";             ///< the receiver's port our cable is in
  std::string correction_port = "B";       ///< the receiver's port that hears RTCM; may be the same
  bool save = false;                       ///< the receiver keeps the set-up without power
  double latency_s = 0.05;     ///< epoch to first byte at the very least, for the clock without PPS
  double latency_sd_s = 0.01;  ///< how well that is known
  PpsSettings pps;
  Eigen::Vector3d antenna_frd_m = Eigen::Vector3d::Zero();  ///< from the body's reference point

  template <class V>
  void Visit(V& v) {
    v("device", device, config::NotEmpty{});
    v("baud_bps", baud_bps,
      config::OneOf{4800, 9600, 19200, 38400, 57600, 115200, 230400, 460800, 921600});
    v("profile", profile, config::OneOf{"nmea", "ashtech-legacy", "ashtech"});
    v("configure", configure, config::Optional{});
    v("period_s", period_s, config::Range{0.05, 10.0}, config::Optional{});
    v("data_port", data_port, config::OneOf{"A", "B", "C", "D"}, config::Optional{});
    v("correction_port", correction_port, config::OneOf{"A", "B", "C", "D"}, config::Optional{});
    v("save", save, config::Optional{});
    v("latency_s", latency_s, config::Range{0.0, 2.0}, config::Optional{});
    v("latency_sd_s", latency_sd_s, config::Range{0.0001, 1.0}, config::Optional{});
    v("pps", pps, config::Optional{});
    v("antenna_frd_m", antenna_frd_m, config::Range{-20.0, 20.0}, config::Optional{});
  }
};

struct AhrsConfig {
  std::string device;
  int baud_bps = 38400;
  std::string mode = "angle";
  int model = 100;                        ///< AHRS400CC-100 or -200: the scale of its numbers
  double acceleration_sign = 1.0;         ///< -1 for units that send +1 g on z when level
  double magnetic_declination_deg = 0.0;  ///< east positive; magnetic + declination = true heading

  template <class V>
  void Visit(V& v) {
    v("device", device, config::NotEmpty{});
    v("baud_bps", baud_bps, config::OneOf{9600, 19200, 38400, 57600, 115200}, config::Optional{});
    v("mode", mode, config::OneOf{"angle", "scaled"}, config::Optional{});
    v("model", model, config::OneOf{100, 200});
    v("acceleration_sign", acceleration_sign, config::OneOf{-1, 1}, config::Optional{});
    v("magnetic_declination_deg", magnetic_declination_deg, config::Range{-180.0, 180.0},
      config::Optional{});
  }
};

/// The RTK-GPS/INS filter; the attitude unit is its inertial unit.
struct NavigationSettings {
  bool filter = true;                    ///< false: fix and attitude unit, interpolated
  std::string sensor = "ahrs400cc-100";  ///< profile of the inertial unit's errors
  estimation::SensorFigures imu;         ///< its own, Allan figures say, in place of the profile's
  std::string constraint = "auto";  ///< the vehicle moves neither sideways nor up, as far as seen
  double time_offset_sd_s = 0.02;   ///< inertial stamps against GNSS epochs; 0: they agree
  double max_lateness_s = 0.5;      ///< older measurements are refused

  template <class V>
  void Visit(V& v) {
    v("filter", filter, config::Optional{});
    v("sensor", sensor, config::OneOf{"ahrs400cc-100", "consumer-mems", "industrial-mems"},
      config::Optional{});
    v("imu", imu, config::Optional{});
    v("constraint", constraint, config::OneOf{"auto", "off"}, config::Optional{});
    v("time_offset_sd_s", time_offset_sd_s, config::Range{0.0, 0.5}, config::Optional{});
    v("max_lateness_s", max_lateness_s, config::Range{0.1, 2.0}, config::Optional{});
  }
};

struct CorrectionsConfig {
  std::string source = "none";
  std::string device;  ///< serial radio
  int baud_bps = 9600;
  std::string host;  ///< NTRIP caster
  int port = 2101;
  std::string mountpoint;
  std::string user;
  std::string password;
  int ntrip_version = 2;
  double alarm_age_s = 5.0;

  template <class V>
  void Visit(V& v) {
    v("source", source, config::OneOf{"none", "ntrip", "serial", "lcm"});
    v("device", device, config::Optional{});
    v("baud_bps", baud_bps, config::OneOf{4800, 9600, 19200, 38400, 57600, 115200},
      config::Optional{});
    v("host", host, config::Optional{});
    v("port", port, config::Range{1, 65535}, config::Optional{});
    v("mountpoint", mountpoint, config::Optional{});
    v("user", user, config::Optional{});
    v("password", password, config::Optional{});
    v("ntrip_version", ntrip_version, config::OneOf{1, 2}, config::Optional{});
    v("alarm_age_s", alarm_age_s, config::Range{1.0, 600.0}, config::Optional{});
    v.Require(source != "serial" || !device.empty(), "device", "the radio's serial port");
    v.Require(source != "ntrip" || !host.empty(), "host", "the caster's name or address");
    v.Require(source != "ntrip" || !mountpoint.empty(), "mountpoint", "a stream of the caster");
  }
};

struct ScheduleSettings {
  ScheduleConfig rule;

  template <class V>
  void Visit(V& v) {
    v("every_epochs", rule.every_epochs, config::Range{0, 100000});
    v("every_m", rule.every_m, config::Range{0.0, 10000.0}, config::Optional{});
    v("free_run_period_s", rule.free_run_period_s, config::Range{0.0, 3600.0}, config::Optional{});
    v("free_run_after_s", rule.free_run_after_s, config::Range{0.0, 3600.0}, config::Optional{});
  }
};

struct RecordConfig {
  bool enabled = true;
  std::string folder = "log";
  double segment_s = 600.0;
  double segment_mb = 256.0;
  double navigation_sync_s = 0.1;  ///< what a power cut may cost
  double picture_sync_s = 1.0;
  double disk_reserve_mb = 1024.0;  ///< below it the oldest pictures give way

  template <class V>
  void Visit(V& v) {
    v("enabled", enabled, config::Optional{});
    v("folder", folder, config::NotEmpty{});
    v("segment_s", segment_s, config::Range{1.0, 86400.0}, config::Optional{});
    v("segment_mb", segment_mb, config::Range{1.0, 16384.0}, config::Optional{});
    v("navigation_sync_s", navigation_sync_s, config::Range{0.01, 60.0}, config::Optional{});
    v("picture_sync_s", picture_sync_s, config::Range{0.01, 60.0}, config::Optional{});
    v("disk_reserve_mb", disk_reserve_mb, config::Range{0.0, 1048576.0}, config::Optional{});
  }
};

struct RealtimeConfig {
  int priority = 60;  ///< SCHED_FIFO of the loop; 0: normal scheduling
  bool lock_memory = true;

  template <class V>
  void Visit(V& v) {
    v("priority", priority, config::Range{0, 80}, config::Optional{});
    v("lock_memory", lock_memory, config::Optional{});
  }
};

/// The computer's own clock, which the robot does without.
struct SystemClockConfig {
  int ntp_shm_unit = -1;  ///< of chronyd's `refclock SHM`, which is told GPS time; -1: of none

  template <class V>
  void Visit(V& v) {
    v("ntp_shm_unit", ntp_shm_unit, config::Range{-1, 255}, config::Optional{});
  }
};

struct OnboardConfig {
  RobotConfig robot;
  GpsConfig gps;
  AhrsConfig ahrs;
  NavigationSettings navigation;
  CameraConfig camera;
  vision::Phase1PictureConfig picture;
  ScheduleSettings schedule;
  CorrectionsConfig corrections;
  RecordConfig record;
  RealtimeConfig realtime;
  SystemClockConfig system_clock;
  std::string lcm_url;  ///< empty: LCM's default group on this machine

  template <class V>
  void Visit(V& v) {
    v("robot", robot);
    v("gps", gps);
    v("ahrs", ahrs);
    v("navigation", navigation, config::Optional{});
    v("camera", camera);
    v("picture", picture);
    v("schedule", schedule);
    v("corrections", corrections, config::Optional{});
    v("record", record);
    v("realtime", realtime, config::Optional{});
    v("system_clock", system_clock, config::Optional{});
    v("lcm_url", lcm_url, config::Optional{});
  }
};

}  // namespace kawara::onboard
