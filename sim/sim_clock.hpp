#pragma once
#include <cmath>

#include "core/time.hpp"

namespace kawara::sim {

/// Where recorded GPS time lies on this machine's monotonic clock: a straight line through one pair
/// of instants. `gps_per_mono` is 1 for true pace; 1 + 1e-6 ppm makes the machine's crystal wrong,
/// 2 replays at double speed. Immutable; any thread.
class SimClock {
 public:
  SimClock(core::GpsTime gps, core::MonoTime mono, double gps_per_mono)
      : gps_(gps), mono_(mono), gps_per_mono_(gps_per_mono) {}

  core::MonoTime MonoAt(core::GpsTime t) const {
    return mono_ + Scale(t - gps_, 1.0 / gps_per_mono_);
  }
  core::GpsTime GpsAt(core::MonoTime t) const { return gps_ + Scale(t - mono_, gps_per_mono_); }
  double gps_per_mono() const { return gps_per_mono_; }

 private:
  /// Exact where the factor is 1, so that true pace keeps every nanosecond.
  static core::Duration Scale(core::Duration d, double factor) {
    if (factor == 1.0) return d;
    return core::Nanoseconds(std::llround(static_cast<double>(d.count()) * factor));
  }

  core::GpsTime gps_;
  core::MonoTime mono_;
  double gps_per_mono_;
};

}  // namespace kawara::sim
