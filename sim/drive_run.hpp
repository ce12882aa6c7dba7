#pragma once
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "sim/ahrs400.hpp"
#include "sim/camera_server.hpp"
#include "sim/doughnut_geometry.hpp"
#include "sim/faults.hpp"
#include "sim/gps_receiver.hpp"

namespace kawara::sim {

/// Everything `kawara-sim drive` can be told.
struct DriveOptions {
  std::filesystem::path data;        ///< recording's folder
  std::filesystem::path run_dir;     ///< gets gps, ahrs, camera.sock, truth_*.csv, ready
  std::filesystem::path panorama;    ///< stitched picture, or a folder of JPEGs; empty: no camera
  double start_s = 0.0;              ///< from the first instant that both recorded streams cover
  std::optional<double> duration_s;  ///< none: to the end
  double speed = 1.0;
  double machine_skew_ppm = 0.0;  ///< GPS time runs this much faster than this machine's clock
  bool now = false;               ///< recording moved by whole seconds to the present
  double imu_advance_s =
      0.0;  ///< IMU stamps moved back by this: takes out the recorded lateness if wished
  bool realtime = true;  ///< ask for SCHED_FIFO; going without is no error
  double lead_s = 0.5;   ///< from "ready" to the first recorded instant
  GpsReceiverOptions gps;
  Ahrs400Options ahrs;
  CameraOptions camera;
  vision::DoughnutParameters doughnut = StandardDoughnut(2048);
  int jpeg_quality = 88;
  std::vector<Fault> faults;
};

struct DriveSummary {
  double ran_s = 0.0;
  bool stopped_early = false;
  GpsReceiver::Counters gps;
  SerialLine::Counters gps_line;
  std::uint64_t gps_dropped_messages = 0;
  Ahrs400::Counters ahrs;
  SerialLine::Counters ahrs_line;
  std::uint64_t ahrs_saturated = 0;
  CameraServer::Counters camera;
  core::Duration latest_wakeup{};  ///< worst lateness of the pacing thread
  std::string ToText() const;      ///< one line
};

/// Replays a recorded drive on simulated instruments until its end or `stop`. Blocks; the calling
/// thread does the pacing by absolute sleeps on the monotonic clock, the camera has a thread of its
/// own. All links, sockets and the ready file are gone afterwards, the truth files stay. Errors:
/// data, options, run-dir.
core::Expected<DriveSummary> RunDrive(const DriveOptions& options, const std::atomic<bool>& stop);

}  // namespace kawara::sim
