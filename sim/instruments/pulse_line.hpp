#pragma once
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "core/time.hpp"
#include "drivers/pps.hpp"
#include "sim/dice.hpp"

namespace kawara::sim {

struct PulseOptions {
  double latency_s = 10e-6;  ///< edge to the stamp of the interrupt, least
  double jitter_s = 5e-6;    ///< mean of what comes on top
  std::uint64_t seed = 4;
};

/// The wire from the receiver's PPS output to the interrupt of the robot's computer: every edge
/// gets a stamp a little after it happened, and things go wrong. Time is what the caller says. One
/// thread.
class PulseLine {
 public:
  struct Faults {
    bool lost = false;     ///< no edges
    bool jittery = false;  ///< stamps up to several milliseconds late
    bool doubled = false;  ///< a spurious edge somewhere in each second
  };
  explicit PulseLine(const PulseOptions& options) : options_(options), dice_(options.seed) {}

  /// The receiver's output rose at `edge`.
  void OnEdge(core::MonoTime edge, const Faults& faults);
  /// Edges whose stamp has come by `now`, in the order of their stamps.
  std::vector<drivers::PpsEdge> Take(core::MonoTime now);
  /// When the next one comes; unset: none under way.
  core::MonoTime NextDue() const { return stamps_.empty() ? core::MonoTime{} : stamps_.front(); }
  std::uint32_t edges() const { return sequence_; }

 private:
  void Add(core::MonoTime stamp);

  PulseOptions options_;
  Dice dice_;
  std::deque<core::MonoTime> stamps_;  ///< ascending
  std::uint32_t sequence_ = 0;
};

}  // namespace kawara::sim
