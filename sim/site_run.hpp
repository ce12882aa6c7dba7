#pragma once
#include <atomic>
#include <optional>

#include "core/expected.hpp"
#include "sim/camera/doughnut_geometry.hpp"
#include "sim/run/instrument_run.hpp"
#include "sim/virtual/virtual_run.hpp"
#include "sim/world/rendered_pictures.hpp"
#include "sim/world/site_world.hpp"
#include "vision/camera/camera_choice.hpp"

namespace kawara::sim {

/// Everything `kawara-sim site` can be told.
struct SiteRunOptions {
  SiteWorldOptions world;
  double start_s = 0.0;              ///< of the mission
  std::optional<double> duration_s;  ///< none: to the end
  bool now = false;                  ///< the played part begins at the present whole second
  bool camera = true;
  /// Seconds between exposures that are drawn before the run begins, unless this machine is quick
  /// enough to draw them while it runs; 0: drawn while it runs in any case.
  double ahead_period_s = 0.0;
  vision::CameraChoice optics = vision::CameraChoice::Of(StandardDoughnut(1448));
  RenderedCameraOptions rendering;
  InstrumentOptions instruments;
  std::optional<VirtualTime> virtual_time;  ///< none: in real time, on pseudo-terminals
};

/// Makes the world, writes its truth into the run-dir (see WriteWorldTruth), and plays the drive on
/// simulated instruments with rendered pictures (see RunInstruments, RunVirtual). Errors: files,
/// options, run-dir.
core::Expected<InstrumentSummary> RunSite(SiteRunOptions options, const std::atomic<bool>& stop);

}  // namespace kawara::sim
