#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "core/expected.hpp"
#include "core/time.hpp"
#include "drivers/pps.hpp"

namespace kawara::drivers {

enum class PulseEdge : std::uint8_t { kRising, kFalling };

/// CLOCK_REALTIME and CLOCK_MONOTONIC read back to back: how the kernel's stamps of pulses, which
/// are of the first, are brought to the second.
struct ClockPair {
  std::int64_t realtime_ns = 0;
  core::MonoTime mono;
  /// The better of a few readings: the one whose two monotonic ends lie closest.
  static ClockPair Read();
  std::int64_t offset_ns() const { return realtime_ns - mono.ns(); }
};

/// The monotonic instant of a stamp of CLOCK_REALTIME, seen from `now`. Empty: between `before` and
/// `now` the system clock was set (by more than kClockStep), and nobody knows whether the stamp is
/// of before or after; or the stamp lies in the future. Pure.
std::optional<core::MonoTime> OnMonotonic(std::int64_t stamp_realtime_ns, const ClockPair& before,
                                          const ClockPair& now);
/// More than the fastest slewing moves a clock (8 %, chrony's limit) while an edge is waited for.
constexpr core::Duration kClockStep = core::Milliseconds(25);

/// Pulses as the kernel stamps them: /dev/ppsN (Linux PPS API, linux/pps.h, after RFC 2783). Opened
/// on demand by Next() and again after every loss. An edge that was there before the opening is not
/// told; edges that come between two calls are counted by their sequence, and the newest is told.
/// One thread.
class KernelPps final : public PpsSource {
 public:
  struct Stats {
    std::uint64_t opened = 0;
    std::uint64_t edges = 0;
    std::uint64_t clock_steps = 0;  ///< edges left out because the system clock was set just then
  };

  KernelPps(std::string device, PulseEdge edge) : device_(std::move(device)), edge_(edge) {}
  ~KernelPps() override;
  KernelPps(const KernelPps&) = delete;
  KernelPps& operator=(const KernelPps&) = delete;

  /// Errors, one line with its cure: kNotFound, kPermission, kInvalidArgument (no PPS device, a
  /// kernel timer, an edge it does not stamp), kUnavailable (unplugged).
  core::Expected<std::optional<PpsEdge>> Next(core::Duration timeout) override;
  const Stats& stats() const { return stats_; }

 private:
  struct Latest {
    std::uint32_t sequence = 0;
    std::int64_t realtime_ns = 0;
  };
  core::Expected<void> Open();
  core::Expected<void> CheckIsPulse();
  tl::unexpected<core::Error> Lose(core::Error why);
  /// The newest edge; waits up to `timeout` for one that was not there when it was called.
  core::Expected<Latest> Fetch(core::Duration timeout);
  bool IsStillThere() const;

  std::string device_;
  PulseEdge edge_;
  int fd_ = -1;
  std::uint64_t inode_ = 0, rdev_ = 0;
  std::uint32_t last_sequence_ = 0;
  Stats stats_;
};

}  // namespace kawara::drivers
