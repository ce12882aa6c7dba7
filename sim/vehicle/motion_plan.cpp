#include "sim/vehicle/motion_plan.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/geodesy.hpp"

namespace kawara::sim {
namespace {

/// A smoothed value rests once its raw value has for this many pitches.
constexpr double kSettle = 3.0;

/// A raw motion: value reached at a time, with constant acceleration in between.
struct Knot {
  double t_s, value, rate;
};

/// Greatest speed along the way from `from_m` to `to_m`, both standing.
std::vector<Knot> Drive(const GroundPath& path, const MotionLimits& limits, double from_m,
                        double to_m, double begin_s) {
  const double length_m = to_m - from_m;
  const auto steps = static_cast<std::size_t>(
      std::ceil(length_m / std::clamp(length_m / 20000.0, 0.02, 0.2)) + 1.0);
  const double step_m = length_m / static_cast<double>(steps);
  std::vector<double> square(steps + 1);  // of the speed
  for (std::size_t i = 0; i <= steps; ++i) {
    const double way_m = from_m + static_cast<double>(i) * step_m;
    const double curvature = std::abs(path.At(way_m).heading_d1);
    double speed = path.SpeedAt(way_m);
    if (curvature > 1e-6) {
      speed = std::min({speed, std::sqrt(limits.lateral_mps2 / curvature),
                        limits.turn_rate_degps * core::kRadFromDeg / curvature});
    }
    square[i] = speed * speed;
  }
  square.front() = square.back() = 0.0;
  for (std::size_t i = 1; i <= steps; ++i)
    square[i] = std::min(square[i], square[i - 1] + 2.0 * limits.acceleration_mps2 * step_m);
  for (std::size_t i = steps; i-- > 0;)
    square[i] = std::min(square[i], square[i + 1] + 2.0 * limits.deceleration_mps2 * step_m);

  std::vector<Knot> knots{{begin_s, from_m, 0.0}};
  for (std::size_t i = 1; i <= steps; ++i) {
    const double rate = std::sqrt(square[i]);
    const double t_s = knots.back().t_s + 2.0 * step_m / (knots.back().rate + rate);
    knots.push_back({t_s, from_m + static_cast<double>(i) * step_m, rate});
  }
  knots.back().value = to_m;
  return knots;
}

/// A turn on the spot by an angle: speed up, steady, slow down.
std::vector<Knot> Turn(const MotionLimits& limits, double from_rad, double by_rad, double begin_s) {
  const double greatest = limits.turn_rate_degps * core::kRadFromDeg;
  const double acceleration = limits.turn_acceleration_degps2 * core::kRadFromDeg;
  const double rate = std::min(greatest, std::sqrt(std::abs(by_rad) * acceleration));
  const double ramp_s = rate / acceleration;
  const double steady_s = std::abs(by_rad) / rate - ramp_s;
  const double sign = std::copysign(1.0, by_rad);
  const double ramp_rad = sign * rate * ramp_s / 2.0;
  return {{begin_s, from_rad, 0.0},
          {begin_s + ramp_s, from_rad + ramp_rad, sign * rate},
          {begin_s + ramp_s + steady_s, from_rad + by_rad - ramp_rad, sign * rate},
          {begin_s + 2.0 * ramp_s + steady_s, from_rad + by_rad, 0.0}};
}

/// Values at a steady pitch of knots in order of time; at rest before, after and between motions.
std::vector<double> Sample(const std::vector<Knot>& knots, double pitch_s, double duration_s) {
  const auto count = static_cast<std::size_t>(std::ceil(duration_s / pitch_s)) + 1;
  std::vector<double> values(count);
  std::size_t next = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double t_s = static_cast<double>(i) * pitch_s;
    while (next < knots.size() && knots[next].t_s <= t_s) ++next;
    if (next == 0) {
      values[i] = knots.empty() ? 0.0 : knots.front().value;
    } else if (next == knots.size()) {
      values[i] = knots.back().value;
    } else {
      const Knot& a = knots[next - 1];
      const Knot& b = knots[next];
      const double dt_s = t_s - a.t_s;
      const double acceleration = (b.rate - a.rate) / (b.t_s - a.t_s);
      values[i] = a.value + (a.rate + 0.5 * acceleration * dt_s) * dt_s;
    }
  }
  return values;
}

void Append(std::vector<Knot>& to, const std::vector<Knot>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

}  // namespace

MotionPlan::MotionPlan(const GroundPath& path, const MotionLimits& limits,
                       const PathConfig& config) {
  // Smoothing turns a jump of the acceleration into a jerk of 0.6 jumps a pitch.
  const double pitch_s = std::clamp(
      0.6 * (limits.acceleration_mps2 + limits.deceleration_mps2) / limits.jerk_mps3, 0.05, 1.0);
  const double settle_s = kSettle * pitch_s;
  std::vector<Knot> way, turn;
  double now_s = config.stand_before_s + config.waypoints.front().stop_s + settle_s;
  double from_m = 0.0;
  double turned_rad = 0.0;
  std::vector<GroundPath::Stop> stops = path.stops();
  stops.push_back({path.length_m(), 0.0, 0.0});
  for (const GroundPath::Stop& stop : stops) {
    if (stop.way_m > from_m) {
      Append(way, Drive(path, limits, from_m, stop.way_m, now_s));
      from_m = stop.way_m;
      now_s = way.back().t_s + settle_s;
    }
    now_s += stop.stand_s;
    if (stop.turn_rad != 0.0) {
      now_s += settle_s;
      Append(turn, Turn(limits, turned_rad, stop.turn_rad, now_s));
      turned_rad += stop.turn_rad;
      now_s = turn.back().t_s + settle_s;
    }
    now_s += settle_s;
  }
  duration_s_ = now_s - settle_s + config.waypoints.back().stop_s + config.stand_after_s;
  way_ = SmoothSeries(Sample(way, pitch_s, duration_s_), pitch_s);
  turn_ = SmoothSeries(Sample(turn, pitch_s, duration_s_), pitch_s);
}

}  // namespace kawara::sim
