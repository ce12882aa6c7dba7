#pragma once
#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/expected.hpp"
#include "sim/camera/camera_server.hpp"
#include "sim/camera/picture_source.hpp"
#include "sim/faults/fault_command.hpp"
#include "sim/run/instrument_set.hpp"

namespace kawara::sim {

/// How instruments are played, whatever drive they measure.
struct InstrumentOptions : InstrumentSetup {
  std::filesystem::path run_dir;  ///< gets gps, ahrs, laser1.., *.sock, truth_*.csv, ready
  double speed = 1.0;
  double machine_skew_ppm = 0.0;  ///< GPS time runs this much faster than this machine's clock
  bool realtime = true;           ///< ask for SCHED_FIFO; going without is no error
  double lead_s = 0.5;            ///< from "ready" to the first instant
  CameraOptions camera;
  std::optional<std::string> lcm_url;  ///< bus on which faults may be ordered; none: nowhere
  std::string command_channel = kDefaultFaultChannel;
};

struct InstrumentSummary {
  double ran_s = 0.0;
  bool stopped_early = false;
  InstrumentSet::Counters instruments;
  CameraServer::Counters camera;
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
