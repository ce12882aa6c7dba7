#include "sim/vehicle/odometry.hpp"

#include <array>
#include <cmath>

#include "sim/vehicle/instrument_clock.hpp"
#include "sim/vehicle/random_processes.hpp"

namespace kawara::sim {
namespace {

constexpr double kStep_s = 0.01;
constexpr double kSlipTau_s = 2.0;
constexpr double kSlipUnevenness = 0.3;  ///< slip comes and goes by this share of its mean

/// Things that happen now and then to one side: when the next begins, how long it lasts.
class Mishap {
 public:
  Mishap(double per_min, double length_s, std::uint64_t seed)
      : per_min_(per_min), length_s_(length_s), dice_(seed) {
    Draw(0.0);
  }
  /// -1: none at this time (times in order); else the side, 0 left, 1 right.
  int SideAt(double t_s) {
    if (per_min_ <= 0.0) return -1;
    while (t_s >= end_s_) Draw(end_s_);
    return t_s >= begin_s_ ? side_ : -1;
  }
  double size() const { return size_; }  ///< mean 1

 private:
  void Draw(double after_s) {
    if (per_min_ <= 0.0) return;
    begin_s_ = after_s + 60.0 / per_min_ * dice_.Exponential();
    end_s_ = begin_s_ + length_s_ * dice_.Exponential();
    size_ = dice_.Exponential();
    side_ = dice_.Uniform() < 0.5 ? 0 : 1;
  }
  double per_min_, length_s_;
  Dice dice_;
  double begin_s_ = 0.0, end_s_ = 0.0, size_ = 0.0;
  int side_ = 0;
};

}  // namespace

std::vector<OdometrySample> MeasureOdometry(const Trajectory& trajectory,
                                            const VehicleConfig& vehicle,
                                            const OdometryConfig& config, std::uint64_t seed) {
  Dice dice(SeedOf(seed, "wheels"));
  std::array<double, 2> gain{};
  for (double& side : gain) side = 1.0 + config.scale * DrawnNormal(dice);
  GaussMarkov unevenness(kSlipTau_s, dice);
  Mishap burst(config.slip_bursts_per_min, config.event_s, SeedOf(seed, "burst"));
  Mishap skid(config.skids_per_min, config.event_s, SeedOf(seed, "skid"));
  InstrumentClock clock(config.clock, 1.0 / config.rate_hz, SeedOf(seed, "clock"));

  const double end_s = core::ToSeconds(trajectory.end() - trajectory.begin());
  std::array<double, 2> way_m{}, wheel_m{};
  std::array<std::int64_t, 2> ticks{}, last_ticks{};
  bool slipping = false;
  double t_s = 0.0;
  std::vector<OdometrySample> samples;
  for (; clock.true_s() <= end_s; clock.Next()) {
    // Way by the midpoint rule in short steps up to this reading.
    const auto steps = static_cast<int>(std::ceil((clock.true_s() - t_s) / kStep_s));
    const double step_s = (clock.true_s() - t_s) / steps;
    for (int i = 0; i < steps; ++i, t_s += step_s) {
      const double middle_s = t_s + 0.5 * step_s;
      const MotionState state = trajectory.AtSeconds(middle_s);
      const Eigen::Vector3d axle(vehicle.turning_point_forward_m, 0.0, vehicle.reference_height_m);
      const double ahead_mps = state.R_enu_body.col(0).dot(state.PointVelocityEnu(axle));
      // The body's turn about its own down axis moves the left wheels ahead.
      const double turning_mps = state.rate_body_radps.z() * vehicle.track_m / 2.0;
      const double uneven = 1.0 + kSlipUnevenness * unevenness.Step(step_s, dice).x();
      const int spinning = burst.SideAt(middle_s);
      const int locked = skid.SideAt(middle_s);
      slipping = slipping || spinning >= 0 || locked >= 0;
      for (int side = 0; side < 2; ++side) {
        const auto k = static_cast<std::size_t>(side);
        const double turning = side == 0 ? turning_mps : -turning_mps;
        way_m[k] += (ahead_mps + turning) * step_s;
        if (side == locked) continue;
        double wheel_mps =
            ahead_mps * (1.0 + config.slip * uneven) + turning * (1.0 + config.turn_slip * uneven);
        if (side == spinning) wheel_mps *= 1.0 + config.slip_burst_share * burst.size();
        wheel_m[k] += gain[k] * wheel_mps * step_s;
      }
    }
    for (std::size_t k = 0; k < 2; ++k)
      ticks[k] = static_cast<std::int64_t>(std::floor(wheel_m[k] * config.ticks_per_m));
    OdometrySample& sample = samples.emplace_back();
    sample.time = trajectory.begin() + core::DurationFromSeconds(clock.true_s());
    sample.stamp = trajectory.begin() + core::DurationFromSeconds(clock.stamp_s());
    sample.left_ticks = ticks[0];
    sample.right_ticks = ticks[1];
    const double per_tick_mps = config.rate_hz / config.ticks_per_m;
    sample.left_mps = static_cast<double>(ticks[0] - last_ticks[0]) * per_tick_mps;
    sample.right_mps = static_cast<double>(ticks[1] - last_ticks[1]) * per_tick_mps;
    sample.true_left_m = way_m[0];
    sample.true_right_m = way_m[1];
    sample.slipping = slipping;
    last_ticks = ticks;
    slipping = false;
  }
  return samples;
}

}  // namespace kawara::sim
