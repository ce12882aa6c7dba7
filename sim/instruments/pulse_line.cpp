#include "sim/instruments/pulse_line.hpp"

#include <algorithm>

namespace kawara::sim {
namespace {

/// Mean lateness of a stamp under the fault: an interrupt that waits for others.
constexpr double kBadJitter_s = 2e-3;

}  // namespace

void PulseLine::OnEdge(core::MonoTime edge, const Faults& faults) {
  // Drawn in any case, so that a fault changes nothing of what comes after it.
  const double lateness = dice_.Exponential();
  const double place_s = 0.1 + 0.8 * dice_.Uniform();
  if (faults.lost) return;
  const double jitter_s = faults.jittery ? kBadJitter_s : options_.jitter_s;
  const core::MonoTime stamp =
      edge + core::DurationFromSeconds(options_.latency_s + jitter_s * lateness);
  Add(stamp);
  if (faults.doubled) Add(edge + core::DurationFromSeconds(place_s));
}

void PulseLine::Add(core::MonoTime stamp) {
  stamps_.insert(std::upper_bound(stamps_.begin(), stamps_.end(), stamp), stamp);
}

std::vector<drivers::PpsEdge> PulseLine::Take(core::MonoTime now) {
  std::vector<drivers::PpsEdge> edges;
  while (!stamps_.empty() && stamps_.front() <= now) {
    edges.push_back({++sequence_, stamps_.front()});
    stamps_.pop_front();
  }
  return edges;
}

}  // namespace kawara::sim
