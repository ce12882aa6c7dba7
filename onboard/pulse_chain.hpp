#pragma once
#include <cstdint>

#include "core/events.hpp"
#include "estimation/gps_timeline.hpp"
#include "onboard/config.hpp"

namespace kawara::onboard {

/// The receiver's pulses on their way into the GPS time line, and one event for each change of what
/// that time rests on: pulses, hold-over after them, earliest arrivals. Real-time safe; one thread;
/// a pure function of its calls.
class PulseChain {
 public:
  struct Stats {
    std::int64_t used = 0;     ///< moved the clock
    std::int64_t waiting = 0;  ///< no certain second yet
    std::int64_t refused = 0;  ///< outliers, and second pulses in one second
    std::int64_t missing = 0;  ///< gaps in the edges' own count
  };

  PulseChain(const PpsSettings& settings, estimation::GpsTimeline& timeline, core::Events& events);

  /// `sequence` as whoever stamped it counts; 0: it does not.
  void OnEdge(core::MonoTime edge, std::uint32_t sequence);
  /// Once a second.
  void Tick(core::MonoTime now);
  const Stats& stats() const { return stats_; }

 private:
  enum class Basis : std::uint8_t { kNotYet, kPulses, kHoldover, kArrivals };
  Basis BasisAt(core::MonoTime now) const;
  void Tell(core::MonoTime now, Basis basis);
  void ComplainOfNone(core::MonoTime now);

  bool wanted_;
  estimation::GpsTimeline& timeline_;
  core::Events& events_;
  Basis basis_ = Basis::kNotYet;
  core::MonoTime waiting_since_;
  std::uint32_t last_sequence_ = 0;
  core::MonoTime last_edge_;
  core::Duration interval_{};  ///< between the last two edges
  Stats stats_;
};

}  // namespace kawara::onboard
