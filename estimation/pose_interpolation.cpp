// The two interpolations of PoseComposer: attitude on SO(3), position between and beyond fixes.
#include <algorithm>
#include <cmath>

#include "estimation/local_frame.hpp"
#include "estimation/pose_composer.hpp"

namespace kawara::estimation {
namespace {

double Square(double v) { return v * v; }

Eigen::Quaterniond RotationBy(const Eigen::Vector3d& angle_rad) {
  const double norm = angle_rad.norm();
  if (norm < 1e-12) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(norm, angle_rad / norm));
}

}  // namespace

PoseComposer::AttitudeAt PoseComposer::AttitudeOf(core::MonoTime t) const {
  AttitudeAt at;
  at.sigma_rad.setConstant(core::kPi);
  const std::size_t n = attitudes_.CountUpTo(t);
  if (n == 0) return at;
  const AttitudeSample& before = attitudes_[n - 1];
  const double since_s = core::ToSeconds(t - before.time);
  double unseen_s = 0.0;  // time for which only the gyro speaks
  Eigen::Quaterniond reference = before.ned_body;
  at.rate_radps = before.rate_radps;
  if (n < attitudes_.size() && attitudes_[n].time - before.time <= config_.max_attitude_gap) {
    const AttitudeSample& after = attitudes_[n];
    const double u = since_s / core::ToSeconds(after.time - before.time);
    reference = before.ned_body.slerp(u, after.ned_body);
    at.rate_radps = (1.0 - u) * before.rate_radps + u * after.rate_radps;
  } else if (t - before.time <= config_.max_attitude_gap) {
    reference = before.ned_body * RotationBy(before.rate_radps * since_s);
    unseen_s = since_s;
  } else {
    return at;
  }
  const Eigen::Quaterniond offset(
      Eigen::AngleAxisd(heading_.offset_rad(), Eigen::Vector3d::UnitZ()));
  at.ned_body = (offset * reference).normalized();
  const double tilt = before.has_attitude ? config_.roll_pitch_sigma_rad : config_.level_sigma_rad;
  const double drift = config_.gyro_sigma_radps * unseen_s;
  at.sigma_rad << std::hypot(tilt, drift), std::hypot(tilt, drift),
      std::min(core::kPi, std::hypot(heading_.sigma_rad(), drift));
  at.known = true;
  return at;
}

std::optional<double> PoseComposer::YawAt(core::MonoTime t) const {
  const AttitudeAt at = AttitudeOf(t);
  if (!at.known) return std::nullopt;
  return core::AttitudeFromRotation(at.ned_body.toRotationMatrix()).yaw_rad;
}

PoseComposer::Velocity PoseComposer::VelocityOf(std::size_t i) const {
  const core::GnssFix& fix = fixes_[i];
  if (fix.has_velocity && fix.velocity_enu_mps.allFinite() && fix.velocity_sd_enu_mps.allFinite()) {
    return {fix.velocity_enu_mps, fix.velocity_sd_enu_mps, true};
  }
  if (i == 0 || fix.time - fixes_[i - 1].time > config_.max_interpolation) return {};
  const core::GnssFix& before = fixes_[i - 1];
  const double dt_s = core::ToSeconds(fix.time - before.time);
  const Eigen::Vector3d var =
      (fix.position_cov_enu_m2 + before.position_cov_enu_m2).diagonal() / Square(dt_s);
  const double accelerated = 0.5 * config_.acceleration_sigma_mps2 * dt_s;
  return {EnuBetween(before.antenna, fix.antenna) / dt_s,
          (var.array() + Square(accelerated)).sqrt().matrix(), true};
}

PoseComposer::PositionAt PoseComposer::PositionOf(core::GpsTime t, const GpsTimeline& clock) const {
  const std::size_t n = fixes_.CountUpTo(t);
  if (n == 0) return {};
  const core::GnssFix& before = fixes_[n - 1];
  if (n < fixes_.size() && fixes_[n].time - before.time <= config_.max_interpolation) {
    return Between(n - 1, t);
  }
  if (t - before.time <= config_.max_extrapolation) return Beyond(n - 1, t, clock);
  PositionAt lost;
  lost.antenna = before.antenna;
  lost.age_s = core::ToSeconds(t - before.time);
  return lost;
}

PoseComposer::PositionAt PoseComposer::Between(std::size_t first, core::GpsTime t) const {
  const core::GnssFix& a = fixes_[first];
  const core::GnssFix& b = fixes_[first + 1];
  const double gap_s = core::ToSeconds(b.time - a.time);
  const double u = core::ToSeconds(t - a.time) / gap_s;
  const Eigen::Vector3d whole = EnuBetween(a.antenna, b.antenna);
  const Velocity va = VelocityOf(first);
  const Velocity vb = VelocityOf(first + 1);
  PositionAt at;
  Eigen::Vector3d moved;
  Eigen::Vector3d velocity_var = Eigen::Vector3d::Zero();
  double unmodelled_m = 0.0;
  if (a.has_velocity && b.has_velocity && va.known && vb.known) {
    // Cubic Hermite: through both positions with both velocities.
    const double ha = u * Square(1.0 - u) * gap_s;
    const double hb = -Square(u) * (1.0 - u) * gap_s;
    moved = Square(u) * (3.0 - 2.0 * u) * whole + ha * va.enu_mps + hb * vb.enu_mps;
    velocity_var =
        (Square(ha) * va.sd_mps.array().square() + Square(hb) * vb.sd_mps.array().square())
            .matrix();
    unmodelled_m = config_.acceleration_sigma_mps2 * Square(gap_s * u * (1.0 - u)) / 2.0;
    at.velocity_enu_mps = (1.0 - u) * va.enu_mps + u * vb.enu_mps;
  } else {
    moved = u * whole;
    unmodelled_m = config_.acceleration_sigma_mps2 * Square(gap_s) * u * (1.0 - u) / 2.0;
    at.velocity_enu_mps = whole / gap_s;
  }
  at.antenna = core::OffsetNed(a.antenna, NedFromEnu(moved));
  // Errors of neighbouring fixes are mostly the same error: no gain from averaging is claimed.
  at.cov_enu_m2 = (1.0 - u) * a.position_cov_enu_m2 + u * b.position_cov_enu_m2;
  at.cov_enu_m2.diagonal() += velocity_var + Eigen::Vector3d::Constant(Square(unmodelled_m));
  at.rtk = a.position_cov_enu_m2.trace() >= b.position_cov_enu_m2.trace() ? a.rtk : b.rtk;
  if (u == 0.0) at.rtk = a.rtk;
  at.age_s = u * gap_s;
  at.known = true;
  return at;
}

PoseComposer::PositionAt PoseComposer::Beyond(std::size_t last, core::GpsTime t,
                                              const GpsTimeline& clock) const {
  const core::GnssFix& fix = fixes_[last];
  const Velocity v = VelocityOf(last);
  const double dt_s = core::ToSeconds(t - fix.time);
  PositionAt at;
  at.antenna = fix.antenna;
  at.cov_enu_m2 = fix.position_cov_enu_m2;
  at.rtk = fix.rtk;
  at.age_s = dt_s;
  if (dt_s == 0.0) {
    at.velocity_enu_mps = v.enu_mps;
    at.known = true;
    return at;
  }
  if (!v.known) return at;  // one fix alone says nothing about any other instant
  // The turn since the fix bends the way: a chord of half the angle, shorter by its sinc.
  double turn_rad = 0.0;
  if (clock.valid()) {
    const auto then = YawAt(clock.ToMono(fix.time).time);
    const auto now = YawAt(clock.ToMono(t).time);
    if (then && now) turn_rad = core::WrapPi(*now - *then);
  }
  const double half = turn_rad / 2.0;
  const double chord = std::abs(half) < 1e-6 ? 1.0 : std::sin(half) / half;
  const auto turned = [](const Eigen::Vector3d& enu, double clockwise_rad) -> Eigen::Vector3d {
    return Eigen::AngleAxisd(-clockwise_rad, Eigen::Vector3d::UnitZ()) * enu;
  };
  Eigen::Vector3d moved = turned(v.enu_mps, half) * dt_s;
  moved.head<2>() *= chord;
  at.antenna = core::OffsetNed(fix.antenna, NedFromEnu(moved));
  at.velocity_enu_mps = turned(v.enu_mps, turn_rad);
  const double unmodelled_m = 0.5 * config_.acceleration_sigma_mps2 * Square(dt_s);
  at.cov_enu_m2.diagonal() +=
      (v.sd_mps * dt_s).array().square().matrix() + Eigen::Vector3d::Constant(Square(unmodelled_m));
  at.known = true;
  return at;
}

}  // namespace kawara::estimation
