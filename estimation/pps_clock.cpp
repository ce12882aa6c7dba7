#include "estimation/pps_clock.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kawara::estimation {
namespace {

constexpr std::int64_t kNsPerS = 1'000'000'000;
/// Votes agree if edge - label moved by less than this between neighbouring votes.
constexpr std::int64_t kVoteToleranceNs = 100'000'000;
/// Labels beyond 146 years are nonsense, and their differences could overflow.
constexpr std::int64_t kMaxLabelNs = std::numeric_limits<std::int64_t>::max() / 2;
/// Before a second is believed its pulses must come one a second: of several phases none is known
/// to be that of the second.
constexpr core::Duration kLonelyPulse = core::Milliseconds(900);
constexpr core::Duration kLabelWindow = core::Milliseconds(500);

double Square(double v) { return v * v; }

bool IsFullSecond(core::GpsTime t) { return t.ns() % kNsPerS == 0; }

core::GpsTime NearestSecond(core::GpsTime t) {
  const std::int64_t rest = ((t.ns() % kNsPerS) + kNsPerS) % kNsPerS;
  return t - core::Nanoseconds(rest) + core::Nanoseconds(rest >= kNsPerS / 2 ? kNsPerS : 0);
}

}  // namespace

PpsClock::Result PpsClock::AddPulse(core::MonoTime edge, std::optional<core::GpsTime> label) {
  if (last_edge_.IsSet() && edge <= last_edge_) {  // stamps of one source cannot run backwards
    ++outliers_;
    return Result::kOutlier;
  }
  before_last_edge_ = last_edge_;
  last_edge_ = edge;
  if (locked_ && ToGps(edge).sigma_s > config_.max_sigma_s) Unlock();
  const Result result = locked_ ? Track(edge) : Result::kUnlabelled;
  // A double or an outlier inherits its neighbour's label: it must not vote.
  if (label && (result == Result::kUsed || result == Result::kUnlabelled)) Vote(edge, *label);
  return result == Result::kUsed && !locked_ ? Result::kUnlabelled : result;
}

void PpsClock::AddLabel(core::GpsTime second, core::MonoTime arrival) {
  const auto recent = [&](core::MonoTime edge) {
    return edge.IsSet() && arrival >= edge && arrival - edge < kLabelWindow;
  };
  if (recent(last_edge_) && !recent(before_last_edge_)) Vote(last_edge_, second);
}

void PpsClock::Vote(core::MonoTime edge, core::GpsTime label) {
  if (!IsFullSecond(label) || label.ns() < 0 || label.ns() > kMaxLabelNs) return;
  if (locked_) {
    if (NearestSecond(ToGps(edge).time) == label) {
      votes_ = 0;
      return;
    }
    ++label_conflicts_;
    if (++votes_ >= config_.confirm_labels) Unlock();
    return;
  }
  if (before_last_edge_.IsSet() && edge - before_last_edge_ < kLonelyPulse) {
    votes_ = 0;
    return;
  }
  const std::int64_t offset_ns = edge.ns() - label.ns();
  const bool agrees = votes_ > 0 && std::abs(offset_ns - vote_offset_ns_) < kVoteToleranceNs;
  votes_ = agrees ? votes_ + 1 : 1;
  vote_offset_ns_ = offset_ns;
  if (votes_ >= config_.confirm_labels) Lock(edge, label);
}

void PpsClock::Lock(core::MonoTime edge, core::GpsTime second) {
  locked_ = true;
  votes_ = 0;
  refused_in_row_ = 0;
  used_since_lock_ = 0;
  ref_gps_ = second;
  ref_mono_ = edge;
  last_pulse_ = edge;
  skew_ = 0.0;
  cov_ = {Square(config_.pulse_sigma_s), 0.0, Square(config_.skew_sigma_ppm * 1e-6)};
  scatter_s2_ = Square(config_.pulse_sigma_s);
}

void PpsClock::Unlock() {
  locked_ = false;
  votes_ = 0;
}

PpsClock::Result PpsClock::Track(core::MonoTime edge) {
  const core::GpsTime second = NearestSecond(ToGps(edge).time);
  const double dt_s = core::ToSeconds(second - ref_gps_);
  const core::MonoTime predicted =
      ref_mono_ + (second - ref_gps_) + core::DurationFromSeconds(skew_ * dt_s);
  const double residual_s = core::ToSeconds(edge - predicted);
  const Covariance p = Propagated(dt_s);
  double innovation_var = p.oo + std::max(Square(config_.pulse_sigma_s), scatter_s2_);
  const double gate_s = std::max(config_.outlier_floor_s, 6.0 * std::sqrt(innovation_var));
  if (std::abs(residual_s) > gate_s) return Refuse(edge, residual_s);
  if (second == ref_gps_) {
    ++doubles_;
    return Result::kDouble;
  }
  // The scatter follows what is seen, at the end one sixteenth at a time, single large ones
  // limited.
  const double limited = std::min(Square(residual_s), 16.0 * innovation_var);
  used_since_lock_ = std::min(used_since_lock_ + 1, 16);
  scatter_s2_ += (std::max(0.0, limited - p.oo) - scatter_s2_) / used_since_lock_;
  // Beyond three sigma a pulse counts for less the farther off it is.
  innovation_var = std::max({innovation_var, Square(residual_s) / 9.0,
                             p.oo + std::max(Square(config_.pulse_sigma_s), scatter_s2_)});
  const double gain_o = p.oo / innovation_var;
  const double gain_s = p.os / innovation_var;
  cov_ = {p.oo * (1.0 - gain_o), p.os * (1.0 - gain_o), p.ss - gain_s * p.os};
  ref_gps_ = second;
  ref_mono_ = predicted + core::DurationFromSeconds(gain_o * residual_s);
  const double limit = 4.0 * config_.skew_sigma_ppm * 1e-6;
  skew_ = std::clamp(skew_ + gain_s * residual_s, -limit, limit);
  last_pulse_ = edge;
  refused_in_row_ = 0;
  return Result::kUsed;
}

PpsClock::Result PpsClock::Refuse(core::MonoTime edge, double residual_s) {
  const bool agrees =
      refused_in_row_ > 0 && std::abs(residual_s - refused_residual_s_) < config_.outlier_floor_s;
  refused_in_row_ = agrees ? refused_in_row_ + 1 : 1;
  refused_residual_s_ = residual_s;
  ++outliers_;
  // Scatter wider than believed would lock every pulse out: let the gate open slowly.
  scatter_s2_ = std::min(scatter_s2_ * 1.2, Square(0.02));
  if (refused_in_row_ < config_.confirm_steps || std::abs(residual_s) > 0.25)
    return Result::kOutlier;
  ++steps_;
  outliers_ -= refused_in_row_;
  const core::GpsTime second = NearestSecond(ToGps(edge).time);
  const double skew = skew_;
  const double skew_var = cov_.ss;
  Lock(edge, second);
  skew_ = skew;
  cov_.ss = skew_var;
  return Result::kStepped;
}

PpsClock::Covariance PpsClock::Propagated(double dt_s) const {
  const double q = Square(config_.skew_wander_ppm * 1e-6) * std::abs(dt_s);
  return {cov_.oo + 2.0 * dt_s * cov_.os + dt_s * dt_s * (cov_.ss + q / 3.0),
          cov_.os + dt_s * (cov_.ss + q / 2.0), cov_.ss + q};
}

double PpsClock::SigmaAt(double dt_s) const {
  return std::sqrt(std::max(0.0, Propagated(dt_s).oo) + Square(config_.pulse_latency_sigma_s));
}

Aligned<core::MonoTime> PpsClock::ToMono(core::GpsTime t) const {
  const double dt_s = core::ToSeconds(t - ref_gps_);
  return {ref_mono_ + (t - ref_gps_) +
              core::DurationFromSeconds(skew_ * dt_s - config_.pulse_latency_s),
          SigmaAt(dt_s)};
}

Aligned<core::GpsTime> PpsClock::ToGps(core::MonoTime t) const {
  const core::Duration since = t - ref_mono_ + core::DurationFromSeconds(config_.pulse_latency_s);
  const double since_s = core::ToSeconds(since);
  const double dt_s = since_s / (1.0 + skew_);
  return {ref_gps_ + since - core::DurationFromSeconds(skew_ * dt_s), SigmaAt(dt_s)};
}

ClockStatus PpsClock::Status(core::MonoTime now) const {
  ClockStatus status;
  status.mono = now;
  status.steps = steps_;
  status.outliers = outliers_ + doubles_;
  if (!locked_) return status;
  const Aligned<core::GpsTime> gps = ToGps(now);
  status.stream = StreamTime::FromNs(gps.time.ns());
  status.sigma_s = gps.sigma_s;
  status.skew_ppm = -skew_ * 1e6;
  status.source =
      now - last_pulse_ > config_.holdover_after ? ClockSource::kHoldover : ClockSource::kPps;
  return status;
}

}  // namespace kawara::estimation
