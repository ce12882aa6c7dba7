#pragma once
#include <atomic>
#include <filesystem>
#include <memory>

#include "core/expected.hpp"
#include "onboard/config.hpp"
#include "sim/run/instrument_run.hpp"

namespace kawara::sim {

/// A run whose time is computed instead of waited for: the instruments of RunInstruments and the
/// core of kawara-onboard in one process on one clock.
struct VirtualTime {
  std::filesystem::path log;  ///< as kawara-onboard would record it; must not exist
  onboard::OnboardConfig onboard;
};

/// Plays a motion on the same instruments as RunInstruments, with kawara-onboard's core at the
/// other end of their cables, as fast as the computer can, until its end or `stop`. The same
/// options give the same log, byte for byte. In the run-dir only the truth is written; pace, bus
/// and real-time options mean nothing here. Errors: run-dir, log, the robot's picture
/// configuration.
core::Expected<InstrumentSummary> RunVirtual(const InstrumentOptions& options,
                                             const VirtualTime& virtual_time,
                                             const MeasuredMotion& motion,
                                             std::unique_ptr<PictureSource> pictures,
                                             const std::atomic<bool>& stop);

}  // namespace kawara::sim
