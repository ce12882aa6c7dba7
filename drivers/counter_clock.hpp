#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/time.hpp"

namespace kawara::drivers {

struct CounterClockConfig {
  double tick_ns = 790.0;  ///< nominal; the true tick is learnt (see max_skew)
  double max_skew = 0.01;  ///< of tick_ns, either way
  core::Duration max_gap =
      core::Seconds(1);  ///< longer silence: the unit may have restarted, start anew
  core::Duration latency =
      core::Nanoseconds(0);  ///< sampling to first byte on the wire, subtracted
};

/// Puts a 16-bit free-running DOWN-counter onto this machine's monotonic clock.
///
/// What is known: ticks are regular (one crystal) but wrap every 51.8 ms; arrivals never wrap but
/// are late by a changing, never negative delay. Two questions follow.
///
/// How often did it wrap since the last packet? As often as the arrivals allow without making this
/// packet come before it was sampled (delays are >= 0 and mostly small). One exception: if no byte
/// was lost in between and one candidate makes the step equal to the learnt packet period, that one
/// is taken, because then the packet was held up with its successors (a burst follows), not its
/// predecessors lost. If packets stay late by the same amount (8 in a row), it was a gap after all:
/// start anew.
///
/// When was it sampled? On the lower envelope of (ticks, arrival): minima of up to 16 windows (0.25
/// s, doubling to 4 s as history grows), under them the line that touches from below with the least
/// total distance, i.e. the edge of the lower convex hull across the mean abscissa. Its slope is
/// the true tick. A packet earlier than the line moves the line down at once. Stamps never go
/// backwards.
///
/// Fixed memory, no allocation. One thread. Pure function of its inputs.
class CounterClock {
 public:
  explicit CounterClock(CounterClockConfig config = {});

  /// Time of sampling of the packet with this counter. `bytes_lost`: something between the last
  /// packet and this one was skipped, so packets may be missing.
  core::MonoTime Update(std::uint16_t counter, core::MonoTime arrival, bool bytes_lost);
  /// Forgets offset and period, keeps the learnt tick. After reconnecting or a change of mode.
  void Restart();

  /// Learnt tick against nominal [ppm], positive: longer.
  double skew_ppm() const { return (rate_ns_ / config_.tick_ns - 1.0) * 1e6; }
  /// Arrival minus the envelope of the last packet: how late it was.
  core::Duration last_delay() const { return core::Duration(last_delay_ns_); }

  struct Stats {
    std::uint64_t packets = 0;
    std::uint64_t late = 0;       ///< arrived more than half a wrap behind the envelope
    std::uint64_t restarts = 0;   ///< anchored anew: first packet, long gap, wrong wrap count found
    std::uint64_t held_back = 0;  ///< stamp would have gone backwards
  };
  const Stats& stats() const { return stats_; }

 private:
  struct Point {
    std::int64_t ticks = 0;
    std::int64_t arrival_ns = 0;
  };
  static constexpr std::size_t kWindows = 16;
  static constexpr std::size_t kRecent = 8;

  core::MonoTime Anchor(std::uint16_t counter, core::MonoTime arrival);
  std::int64_t ChooseWraps(std::uint16_t step, std::int64_t residual_ns, bool bytes_lost) const;
  void LearnPeriod(std::int64_t step_ticks);
  bool PersistentlyLate(std::int64_t residual_ns);
  void AddToEnvelope(std::int64_t ticks, std::int64_t arrival_ns);
  void CloseWindow();
  void Refit();
  double Predict(std::int64_t ticks) const;  ///< [ns] relative to anchor_ns_
  core::MonoTime Finish(core::MonoTime sampled);

  CounterClockConfig config_;
  double rate_ns_;  ///< ns a tick, learnt
  bool anchored_ = false;
  std::uint16_t last_counter_ = 0;
  std::int64_t ticks_ = 0;      ///< since the anchor
  std::int64_t anchor_ns_ = 0;  ///< arrival of the anchor packet
  double offset_ns_ = 0.0;      ///< line: anchor_ns_ + offset_ns_ + rate_ns_ * ticks
  core::MonoTime last_arrival_;
  core::MonoTime last_stamp_;
  std::int64_t last_delay_ns_ = 0;
  double period_ticks_ = 0.0;
  int period_votes_ = 0;
  std::array<std::int64_t, kRecent> recent_residuals_{};
  std::size_t recent_count_ = 0;
  std::array<Point, kWindows> closed_{};
  std::size_t closed_count_ = 0;
  Point window_best_{};
  std::int64_t window_start_ticks_ = 0;
  std::int64_t window_ticks_ = 0;
  bool window_open_ = false;
  Stats stats_;
};

}  // namespace kawara::drivers
