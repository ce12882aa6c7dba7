#pragma once
#include <atomic>
#include <filesystem>
#include <optional>

#include "core/expected.hpp"
#include "sim/camera/doughnut_geometry.hpp"
#include "sim/run/instrument_run.hpp"
#include "sim/virtual/virtual_run.hpp"

namespace kawara::sim {

/// Everything `kawara-sim drive` can be told.
struct DriveOptions {
  std::filesystem::path data;        ///< recording's folder
  std::filesystem::path panorama;    ///< stitched picture, or a folder of JPEGs; empty: no camera
  double start_s = 0.0;              ///< from the first instant that both recorded streams cover
  std::optional<double> duration_s;  ///< none: to the end
  bool now = false;                  ///< recording moved by whole seconds to the present
  double imu_advance_s =
      0.0;  ///< IMU stamps moved back by this: takes out the recorded lateness if wished
  vision::DoughnutParameters doughnut = StandardDoughnut(2048);
  int jpeg_quality = 88;
  InstrumentOptions instruments;
  std::optional<VirtualTime> virtual_time;  ///< none: in real time, on pseudo-terminals
};

/// Replays a recorded drive on simulated instruments (see RunInstruments, RunVirtual). Errors:
/// data, options, run-dir.
core::Expected<InstrumentSummary> RunDrive(const DriveOptions& options,
                                           const std::atomic<bool>& stop);

}  // namespace kawara::sim
