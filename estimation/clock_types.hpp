#pragma once
#include <cstdint>

#include "core/time.hpp"

namespace kawara::estimation {

struct StreamScale {};
/// Time as one instrument counts it: GPS time of epochs, an unwrapped sensor counter. Only
/// differences matter.
using StreamTime = core::TimePoint<StreamScale>;

/// A time on another scale and how well it is known.
template <class Time>
struct Aligned {
  Time time;
  double sigma_s = 0.0;  ///< standard deviation; systematic parts (latency) included
};

/// On what the alignment rests now; numbers as in the CLOCK message.
enum class ClockSource : std::uint8_t {
  kNone = 0,
  kEnvelope = 1,  ///< earliest arrivals
  kPps = 2,       ///< pulses
  kHoldover = 3,  ///< nothing new for a while, extrapolated
};
const char* ToString(ClockSource s);  ///< "none", "envelope", "pps", "hold-over"

/// State of one alignment at one instant.
struct ClockStatus {
  core::MonoTime mono;
  StreamTime stream;      ///< the same instant
  double skew_ppm = 0.0;  ///< stream clock fast (+) against monotonic
  double sigma_s = 0.0;
  ClockSource source = ClockSource::kNone;
  std::int64_t steps = 0;     ///< clock steps or resets of the stream, re-anchored
  std::int64_t outliers = 0;  ///< single samples refused
};

}  // namespace kawara::estimation
