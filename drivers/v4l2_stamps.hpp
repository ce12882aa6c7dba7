#pragma once
#include <cstdint>

#include "core/time.hpp"

namespace kawara::drivers {

/// What lies between the instant a camera stamps and the start of its exposure.
struct V4l2StampRule {
  core::Duration exposure{};  ///< how long the shutter is open
  core::Duration readout{};   ///< end of exposure to end of frame, as the device stamps that
};

/// From a buffer's stamp to the start of its exposure on CLOCK_MONOTONIC. Source: the kernel's
/// V4L2 document, "struct v4l2_buffer", flags V4L2_BUF_FLAG_TIMESTAMP_* and V4L2_BUF_FLAG_TSTAMP_
/// SRC_*.
///
/// Which instant: "start of exposure" is taken as it is (uvcvideo); from "end of frame" (most
/// others) read-out and exposure are taken off.
///
/// Which clock: a stamp that says it is monotonic and lies shortly before its arrival is believed.
/// Any other (unknown clock, copied, the wall clock, a count that has wrapped) is only believed as
/// to how time goes by between frames: it is shifted by the least delay of arrival among the last
/// frames, so that what is left is that least delay. Such a clock may jump or wrap: the shift is
/// then found anew.
///
/// Pure; one thread.
class V4l2StampClock {
 public:
  struct Stamp {
    core::MonoTime exposure_start;
    bool foreign = false;  ///< not of CLOCK_MONOTONIC: shifted by arrivals
    bool of_end = false;   ///< the device stamped the frame's end: the exposure was taken off
  };
  struct Stats {
    std::uint64_t foreign = 0;
    std::uint64_t jumps = 0;  ///< of a foreign clock
  };

  Stamp Take(std::int64_t stamp_s, std::int64_t stamp_us, std::uint32_t flags,
             core::MonoTime arrival, const V4l2StampRule& rule);
  /// A new stream: nothing is known of its clock.
  void Reset();
  const Stats& stats() const { return stats_; }

  /// A monotonic stamp lies so much before its arrival at most ...
  static constexpr core::Duration kMaxDelay = core::Seconds(5);
  /// ... and so much behind it (rounding to microseconds; no frame comes from the future).
  static constexpr core::Duration kMaxAhead = core::Milliseconds(2);
  /// Two frames of a foreign clock may be delayed differently by so much; more is a jump.
  static constexpr core::Duration kJump = core::Seconds(1);

 private:
  core::Duration LeastDelay(std::uint64_t stamp_ns, core::MonoTime arrival);

  static constexpr int kEpochFrames = 64;  ///< the least delay is that of the last one to two such
  bool known_ = false;
  std::uint64_t last_ns_ = 0;
  core::MonoTime last_arrival_;
  core::Duration least_{}, least_before_{};
  int frames_ = 0;
  Stats stats_;
};

}  // namespace kawara::drivers
