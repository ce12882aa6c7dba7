#pragma once
#include <atomic>
#include <cstdint>

namespace kawara::onboard {

/// Counts a thread's rounds, so that another can tell whether it still goes round. Real-time safe;
/// one thread beats, any thread looks.
class Heartbeat {
 public:
  void Beat() { beats_.fetch_add(1, std::memory_order_relaxed); }
  std::uint64_t beats() const { return beats_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> beats_{0};
};

/// Whether a heart has beaten since the last look. One thread.
class HeartWatch {
 public:
  explicit HeartWatch(const Heartbeat& heart) : heart_(&heart) {}
  bool HasBeaten() {
    const std::uint64_t beats = heart_->beats();
    const bool beaten = beats != last_;
    last_ = beats;
    return beaten;
  }

 private:
  const Heartbeat* heart_;
  std::uint64_t last_ = 0;
};

}  // namespace kawara::onboard
