#pragma once
#include "sim/vehicle/ground_path.hpp"
#include "sim/vehicle/smooth_series.hpp"
#include "sim/vehicle/vehicle_config.hpp"

namespace kawara::sim {

/// When the vehicle is where on its path: as fast as wished and as the limits of speed-up, braking,
/// curves and turning allow, smoothed in time so that the jerk stays within its limit too. Standing
/// is exact standing. Immutable.
///
/// How: greatest speed along the way by one pass forwards and one backwards, integrated to way over
/// time with constant acceleration inside each small step, sampled, smoothed by SmoothSeries.
class MotionPlan {
 public:
  MotionPlan(const GroundPath& path, const MotionLimits& limits, const PathConfig& config);

  /// Way [m] and its derivatives by time, at seconds since the start.
  SmoothSeries::Jet WayAt(double t_s) const { return way_.At(t_s); }
  /// Sum of the turns on the spot [rad] and its derivatives.
  SmoothSeries::Jet TurnAt(double t_s) const { return turn_.At(t_s); }
  double duration_s() const { return duration_s_; }

 private:
  SmoothSeries way_, turn_;
  double duration_s_ = 0.0;
};

}  // namespace kawara::sim
