#pragma once
#include <cstddef>
#include <vector>

#include "core/geodesy.hpp"
#include "core/time.hpp"
#include "sim/motion/recording.hpp"

namespace kawara::sim {

/// The best knowledge of where the recorded vehicle was and where it headed at any instant: the
/// simulator's truth.
///
/// Position (of the antenna): Catmull-Rom through the recorded fixes; at the fixes exact, between
/// them good to about a centimetre at the 4 Hz of the drive. Yaw (TRUE heading of the vehicle's
/// nose): the recorded gyro integrated, its slow drift taken out by the course over ground wherever
/// the vehicle moved faster than 1 m/s (backwards driving recognised), forward and backward in
/// time, so that it also holds before the first metre. The recording has no heading reference:
/// expect a degree, not a tenth.
///
/// Immutable after construction; any thread. Outside the recording the ends are held.
class MotionTrack {
 public:
  explicit MotionTrack(const Recording& recording);

  core::Geodetic PositionAt(core::GpsTime t) const;
  /// In (-pi, pi].
  double YawAt(core::GpsTime t) const;
  /// The recorded epoch nearest to t.
  const RecordedFix& NearestFix(core::GpsTime t) const;

 private:
  struct YawKnot {
    core::GpsTime time;
    double yaw_rad;  ///< unwrapped
  };
  std::vector<RecordedFix> fixes_;
  std::vector<YawKnot> yaw_;
};

}  // namespace kawara::sim
