#pragma once
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "sim/ahrs400.hpp"
#include "sim/ahrs_trace.hpp"
#include "sim/camera_server.hpp"
#include "sim/faults.hpp"
#include "sim/gps_receiver.hpp"
#include "sim/picture_source.hpp"
#include "sim/recording.hpp"
#include "sim/sick_scanner.hpp"

namespace kawara::sim {

/// How instruments are played, whatever drive they measure.
struct InstrumentOptions {
  std::filesystem::path run_dir;  ///< gets gps, ahrs, laser1.., camera.sock, truth_*.csv, ready
  double speed = 1.0;
  double machine_skew_ppm = 0.0;  ///< GPS time runs this much faster than this machine's clock
  bool realtime = true;           ///< ask for SCHED_FIFO; going without is no error
  double lead_s = 0.5;            ///< from "ready" to the first instant
  GpsReceiverOptions gps;
  Ahrs400Options ahrs;
  CameraOptions camera;
  std::vector<Fault> faults;
};

/// One laser scanner beside the other instruments.
struct ScannerSetup {
  std::string port;  ///< name of its link in the run-dir: "laser1", "laser2"
  RangeCaster cast;
  SickScannerOptions options;
};

/// What the instruments measure, and the truth of it. Everything referred to must outlive the run.
struct MeasuredMotion {
  const Recording& recording;
  const std::vector<AhrsState>& trace;
  core::GpsTime begin, end;  ///< the part that is played
  std::function<core::Geodetic(core::GpsTime)> antenna_at;
  std::function<double(core::GpsTime)> yaw_at;  ///< true heading [rad]
  std::vector<ScannerSetup> scanners = {};      ///< faults laser1 and laser2 hit the first two
};

struct InstrumentSummary {
  double ran_s = 0.0;
  bool stopped_early = false;
  GpsReceiver::Counters gps;
  SerialLine::Counters gps_line;
  std::uint64_t gps_dropped_messages = 0;
  Ahrs400::Counters ahrs;
  SerialLine::Counters ahrs_line;
  std::uint64_t ahrs_saturated = 0;
  CameraServer::Counters camera;
  std::vector<SickScanner::Counters> scanners;
  core::Duration latest_wakeup{};  ///< worst lateness of the pacing thread
  std::string ToText() const;      ///< one line
};

/// Makes the folder for the ports; before anything that takes long, so that a wrong one shows at
/// once.
core::Expected<void> PrepareRunDir(const std::filesystem::path& run_dir);

/// Plays a motion on simulated instruments until its end or `stop`. Without `pictures` there is no
/// camera. Blocks; the calling thread does the pacing by absolute sleeps on the monotonic clock,
/// the camera has a thread of its own. All links, sockets and the ready file are gone afterwards
/// (also if the process is killed), the truth files stay. Errors: options, run-dir.
core::Expected<InstrumentSummary> RunInstruments(const InstrumentOptions& options,
                                                 const MeasuredMotion& motion,
                                                 std::unique_ptr<PictureSource> pictures,
                                                 const std::atomic<bool>& stop);

}  // namespace kawara::sim
