#pragma once
#include <algorithm>
#include <array>
#include <cstddef>

#include "core/time.hpp"

namespace kawara::onboard {

/// How long a picture waits for the fix of its own epoch: what the slowest of the last fixes took,
/// and half as much again. A receiver that is late by its nature is waited for; one that has just
/// lost an epoch costs little. Real-time safe; one thread.
class FixPatience {
 public:
  /// Instant of validity to the instant the fix was complete here.
  void Add(core::Duration latency) {
    latencies_[next_] = latency;
    next_ = (next_ + 1) % latencies_.size();
    count_ = std::min(count_ + 1, latencies_.size());
  }
  core::Duration Get() const {
    if (count_ < latencies_.size()) return kMost;
    const core::Duration slowest = *std::max_element(latencies_.begin(), latencies_.end());
    return std::clamp(slowest + slowest / 2, kLeast, kMost);
  }

  static constexpr core::Duration kLeast = core::Milliseconds(60);
  /// The slowest receiver in use and its line; also before there is enough experience.
  static constexpr core::Duration kMost = core::Milliseconds(400);

 private:
  std::array<core::Duration, 20> latencies_{};
  std::size_t next_ = 0;
  std::size_t count_ = 0;
};

}  // namespace kawara::onboard
