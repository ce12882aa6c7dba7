#include <CLI/CLI.hpp>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <map>

#include "sim/drive_run.hpp"

namespace {

std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

void RequestStop(int /*signal*/) { stop_requested = true; }

/// The options of `kawara-sim drive`, grouped as --help shows them.
void AddDriveOptions(CLI::App& drive, kawara::sim::DriveOptions& o,
                     std::vector<std::string>& faults) {
  using kawara::sim::GgaQuality;
  drive
      .add_option("--data", o.data,
                  "folder of the recording: gnss.csv[.gz], imu.csv[.gz], site.csv")
      ->required();
  drive
      .add_option("--run-dir", o.instruments.run_dir,
                  "folder for the ports: gps, ahrs, camera.sock, ready, truth_epochs.csv, "
                  "truth_exposures.csv")
      ->required();
  drive.add_option("--panorama", o.panorama,
                   "stitched 360 degree JPEG to render doughnut pictures from, or a folder of "
                   "JPEGs to send in order; "
                   "without it there is no camera");
  drive.add_option("--start", o.start_s, "seconds into the recording")
      ->check(CLI::NonNegativeNumber);
  drive
      .add_option("--duration", o.duration_s,
                  "seconds of recording to replay; to its end if not given")
      ->check(CLI::PositiveNumber);
  drive
      .add_option("--speed", o.instruments.speed,
                  "pace; other than 1 the instruments' clocks no longer fit this machine's")
      ->check(CLI::Range(0.01, 100.0))
      ->capture_default_str();
  drive.add_flag("--now", o.now,
                 "move the recording by whole seconds, so that its start is the present");
  drive
      .add_option(
          "--fault", faults,
          "\"t=30 gps.unplug 5s\": at 30 s of the run, for 5 s (default 5). All there are: " +
              kawara::sim::AllFaultNames() + ". Repeatable")
      ->allow_extra_args(false);
  drive
      .add_option("--lead", o.instruments.lead_s,
                  "seconds between ready and the first recorded instant")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str();
  drive
      .add_option("--skew-ppm", o.instruments.machine_skew_ppm,
                  "GPS time runs this much faster than this machine's clock")
      ->check(CLI::Range(-1000.0, 1000.0));
  drive
      .add_option(
          "--imu-advance", o.imu_advance_s,
          "seconds by which IMU stamps are moved back (0.09 takes out the drive's lateness)")
      ->check(CLI::Range(-1.0, 1.0));
  drive.add_flag("!--no-realtime", o.instruments.realtime, "do not ask for real-time priority");
  drive.add_option("--seed", o.instruments.gps.seed, "of all random delays and errors")
      ->capture_default_str();

  drive.add_option("--gps-port", o.instruments.gps.port, "receiver's port the cable is in, A..D")
      ->check(CLI::IsMember(std::map<std::string, int>{{"A", 0}, {"B", 1}, {"C", 2}, {"D", 3}}))
      ->group("GPS receiver");
  drive.add_option("--gps-baud", o.instruments.gps.baud_bps, "rate saved in the receiver")
      ->check(CLI::IsMember({300, 600, 1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200}))
      ->capture_default_str()
      ->group("GPS receiver");
  drive
      .add_option(
          "--gps-preset", o.instruments.gps.streaming,
          "what is saved in the receiver: off, or streaming (all sentences on, CPD working)")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, bool>{{"off", false}, {"streaming", true}}))
      ->group("GPS receiver");
  drive
      .add_option("--gga-quality", o.instruments.gps.gga_quality,
                  "GGA field 6: legacy (3 fixed, 2 float) or nmea23 (4, 5)")
      ->transform(CLI::CheckedTransformer(std::map<std::string, GgaQuality>{
          {"legacy", GgaQuality::kAshtechLegacy}, {"nmea23", GgaQuality::kNmea23}}))
      ->group("GPS receiver");
  drive.add_option("--gps-latency", o.instruments.gps.latency_s, "seconds from epoch to first bit")
      ->check(CLI::Range(0.0, 5.0))
      ->capture_default_str()
      ->group("GPS receiver");
  drive
      .add_option("--gps-jitter", o.instruments.gps.latency_jitter_s,
                  "mean of the random part of the latency [s]")
      ->check(CLI::Range(0.0, 5.0))
      ->capture_default_str()
      ->group("GPS receiver");
  drive
      .add_flag("--needs-corrections", o.instruments.gps.needs_corrections,
                "without RTCM on its port the receiver loses its fix")
      ->group("GPS receiver");

  drive
      .add_flag("!--ahrs-quiet", o.instruments.ahrs.already_streaming,
                "unit starts polled instead of streaming from the last run")
      ->group("AHRS");
  drive
      .add_option("--ahrs-skew-ppm", o.instruments.ahrs.counter_skew_ppm,
                  "its crystal against this machine's")
      ->check(CLI::Range(-10000.0, 10000.0))
      ->capture_default_str()
      ->group("AHRS");
  drive
      .add_option("--ahrs-range", o.instruments.ahrs.ranges.rate_degps,
                  "model: 100 (2 g) or 200 (4 g)")
      ->check(CLI::IsMember({100.0, 200.0}))
      ->capture_default_str()
      ->group("AHRS");
  drive
      .add_option("--ahrs-accel-sign", o.instruments.ahrs.ranges.force_sign,
                  "1: specific force as it is; -1: negated")
      ->check(CLI::IsMember({1.0, -1.0}))
      ->group("AHRS");

  drive
      .add_option("--camera-delay", o.instruments.camera.exposure_delay_s,
                  "trigger to start of exposure [s]")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str()
      ->group("Camera");
  drive
      .add_option("--camera-jitter", o.instruments.camera.exposure_jitter_s,
                  "standard deviation of it [s]")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str()
      ->group("Camera");
  drive
      .add_option("--camera-readout", o.instruments.camera.readout_s,
                  "start of exposure to first byte of the frame, least [s]")
      ->check(CLI::Range(0.0, 5.0))
      ->capture_default_str()
      ->group("Camera");
  drive
      .add_option_function<int>(
          "--doughnut-px", [&o](int px) { o.doughnut = kawara::sim::StandardDoughnut(px); },
          "side of the doughnut picture (default 2048)")
      ->check(CLI::Range(256, 4096))
      ->group("Camera");
  drive.add_option("--jpeg-quality", o.jpeg_quality, "")
      ->check(CLI::Range(30, 100))
      ->capture_default_str()
      ->group("Camera");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "A robot that does not exist: recorded measurements as real instruments on "
      "pseudo-terminals.");
  app.require_subcommand(1);
  CLI::App& drive = *app.add_subcommand("drive", "replay a recorded drive at true pace");
  kawara::sim::DriveOptions options;
  std::vector<std::string> fault_texts;
  AddDriveOptions(drive, options, fault_texts);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  options.instruments.ahrs.ranges.force_g = options.instruments.ahrs.ranges.rate_degps / 50.0;
  for (const std::string& text : fault_texts) {
    const auto faults = kawara::sim::ParseFaults(text);
    if (!faults) {
      std::fprintf(stderr, "kawara-sim: %s\n", faults.error().message.c_str());
      return 2;
    }
    options.instruments.faults.insert(options.instruments.faults.end(), faults->begin(),
                                      faults->end());
  }
  struct sigaction action {};
  action.sa_handler = RequestStop;
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGINT, &action, nullptr);
  const auto summary = kawara::sim::RunDrive(options, stop_requested);
  if (!summary) {
    std::fprintf(stderr, "kawara-sim: %s\n", summary.error().message.c_str());
    return 2;
  }
  std::printf("%s\n", summary->ToText().c_str());
  return 0;
}
