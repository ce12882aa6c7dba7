#include "drivers/v4l2_stamps.hpp"

#include <linux/videodev2.h>

namespace kawara::drivers {
namespace {

/// Differences wrap as unsigned numbers do: a clock near the end of its range does no harm, nor
/// does a stamp that is nonsense.
core::Duration Wrapped(std::uint64_t a, std::uint64_t b) {
  return core::Duration(static_cast<std::int64_t>(a - b));
}
std::uint64_t Count(core::MonoTime time) { return static_cast<std::uint64_t>(time.ns()); }
std::uint64_t Count(core::Duration time) { return static_cast<std::uint64_t>(time.count()); }

}  // namespace

V4l2StampClock::Stamp V4l2StampClock::Take(std::int64_t stamp_s, std::int64_t stamp_us,
                                           std::uint32_t flags, core::MonoTime arrival,
                                           const V4l2StampRule& rule) {
  const std::uint64_t stamp_ns = static_cast<std::uint64_t>(stamp_s) * 1'000'000'000U +
                                 static_cast<std::uint64_t>(stamp_us) * 1'000U;
  const core::Duration delay = Wrapped(Count(arrival), stamp_ns);
  const bool monotonic =
      (flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  Stamp stamp;
  if (monotonic && delay >= -kMaxAhead && delay <= kMaxDelay) {
    stamp.exposure_start = arrival - delay;
    known_ = false;
  } else {
    stamp.foreign = true;
    ++stats_.foreign;
    // By how much this frame was later than the promptest one.
    stamp.exposure_start = arrival - Wrapped(Count(delay), Count(LeastDelay(stamp_ns, arrival)));
  }
  stamp.of_end = (flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) != V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  if (stamp.of_end) {
    stamp.exposure_start = stamp.exposure_start - rule.readout - rule.exposure;
  }
  return stamp;
}

core::Duration V4l2StampClock::LeastDelay(std::uint64_t stamp_ns, core::MonoTime arrival) {
  const core::Duration delay = Wrapped(Count(arrival), stamp_ns);
  const core::Duration strayed =
      Wrapped(stamp_ns - last_ns_, Count(arrival) - Count(last_arrival_));
  const bool jumped = known_ && (strayed > kJump || strayed < -kJump);
  if (jumped) ++stats_.jumps;
  if (!known_ || jumped) {
    least_ = least_before_ = delay;
    frames_ = 0;
  }
  known_ = true;
  last_ns_ = stamp_ns;
  last_arrival_ = arrival;
  // Old minima are forgotten in steps, so that a clock of another rate is followed.
  if (++frames_ > kEpochFrames) {
    least_before_ = least_;
    least_ = delay;
    frames_ = 1;
  }
  if (Wrapped(Count(delay), Count(least_)).count() < 0) least_ = delay;
  const bool older_is_less = Wrapped(Count(least_before_), Count(least_)).count() < 0;
  return older_is_less ? least_before_ : least_;
}

void V4l2StampClock::Reset() { known_ = false; }

}  // namespace kawara::drivers
