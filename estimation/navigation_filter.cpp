#include "estimation/navigation_filter.hpp"

#include <algorithm>
#include <cmath>

#include "estimation/earth.hpp"
#include "estimation/local_frame.hpp"

namespace kawara::estimation {
namespace {

constexpr double kGap = 0.1;              // s without a sample: what happened meanwhile is a guess
constexpr double kGapAcceleration = 2.0;  // m/s^2 sqrt(s)
constexpr double kGapRate = 0.3;          // rad/s sqrt(s)
constexpr double kSmoothAcceleration = 0.1;  // s

double Square(double v) { return v * v; }

}  // namespace

NavigationFilter::NavigationFilter(const NavigationConfig& config, const NominalState& state,
                                   const ErrorCovariance& covariance)
    : config_(&config), filter_(state, covariance), published_offset_s_(state.time_offset_s) {
  last_position_ = state.stamp;
  last_coloured_ = state.stamp;
}

double NavigationFilter::SecondsSince(core::GpsTime earlier) const {
  return earlier.IsSet() ? core::ToSeconds(state().stamp - earlier) : 1e9;
}

BodyMotion NavigationFilter::Motion() const {
  BodyMotion motion;
  if (holding_) return motion;
  motion.rate_radps = state().TrueRate(sample_.rate_radps);
  motion.acceleration_mps2 = acceleration_mps2_;
  return motion;
}

void NavigationFilter::Advance(const ImuSample& sample, core::GpsTime stamp) {
  if (!has_sample_ || sample.time != sample_.time) {
    sample_before_ = sample_;
    has_sample_before_ = has_sample_;
    sample_ = sample;
    has_sample_ = true;
  }
  const double dt_s = core::ToSeconds(stamp - state().stamp);
  if (dt_s <= 0.0) return;
  ImuInterval imu;
  imu.rate_radps = sample.rate_radps;
  imu.specific_force_mps2 = sample.specific_force_mps2;
  imu.previous_rate_radps = has_sample_before_ ? sample_before_.rate_radps : sample.rate_radps;
  imu.previous_specific_force_mps2 =
      has_sample_before_ ? sample_before_.specific_force_mps2 : sample.specific_force_mps2;
  imu.duration_s = has_sample_before_ ? core::ToSeconds(sample.time - sample_before_.time) : dt_s;
  double extra_acceleration = 0.0, extra_rate = 0.0;
  if (imu.duration_s > kGap) {
    // Both ends of the gap know something of it.
    imu.rate_radps = 0.5 * (imu.rate_radps + imu.previous_rate_radps);
    imu.specific_force_mps2 = 0.5 * (imu.specific_force_mps2 + imu.previous_specific_force_mps2);
    imu.previous_rate_radps = imu.rate_radps;
    imu.previous_specific_force_mps2 = imu.specific_force_mps2;
    extra_acceleration = kGapAcceleration;
    extra_rate = kGapRate;
    last_gap_ = stamp;
    StopHolding();
  }
  if (holding_) {
    held_angle_rad_ += imu.rate_radps * dt_s;
    held_s_ += dt_s;
  }
  filter_.Propagate(imu, dt_s, config_->imu, holding_, extra_acceleration, extra_rate);
  filter_.SetStamp(stamp);
  Eigen::Vector3d acceleration = state().ned_from_body * state().TrueForce(imu.specific_force_mps2);
  acceleration.z() += NormalGravity(state().position.lat_rad, state().position.h_ellipsoidal_m);
  acceleration_mps2_ +=
      std::min(1.0, dt_s / kSmoothAcceleration) * (acceleration - acceleration_mps2_);
}

void NavigationFilter::FinishSample(const ImuSample& sample) {
  const double dt_s = has_sample_before_ ? core::ToSeconds(sample.time - sample_before_.time) : 0.0;
  if (dt_s > 0.0 && dt_s < kGap) {
    const auto& p = filter_.covariance();
    const double bias_sd = std::sqrt(p(kGyroBias, kGyroBias));
    if (holding_ &&
        StandstillDetector::Stirs(sample, dt_s, state().gyro_bias_radps, config_->imu)) {
      StopHolding();
    }
    if (const auto block =
            standstill_.Add(sample, dt_s, state().gyro_bias_radps, bias_sd, config_->imu)) {
      OnBlock(*block);
    }
  } else {
    standstill_.Restart();
  }
  FuseConstraint();
  const double age_s = SecondsSince(last_position_);
  if (age_s > config_->trust.lost_after_s) {
    if (!in_outage_) ++stats_.outages;
    in_outage_ = true;
    stats_.longest_outage_s = std::max(stats_.longest_outage_s, age_s);
  } else {
    in_outage_ = false;
  }
  // The time scale of what is published glides after the estimate, so that it never runs backwards.
  const double glide_s = 0.2 * std::max(dt_s, 0.0);
  published_offset_s_ += std::clamp(state().time_offset_s - published_offset_s_, -glide_s, glide_s);
}

void NavigationFilter::Use(Source source, const MeasurementRows& rows,
                           const Innovation& innovation) {
  auto& counts = stats_.source[static_cast<std::size_t>(source)];
  ++counts.accepted;
  counts.nis_sum += innovation.nis;
  counts.nis_dof += innovation.rows;
  filter_.Update(rows, innovation);
}

bool NavigationFilter::Offer(Source source, const MeasurementRows& rows, double gate) {
  auto& counts = stats_.source[static_cast<std::size_t>(source)];
  ++counts.offered;
  const Innovation innovation = filter_.Predict(rows);
  if (hypothesis_) {
    log_likelihood_ += std::max(-kLikelihoodCap, innovation.LogLikelihood());
  } else if (!(innovation.nis <= gate)) {
    ++counts.rejected;
    return false;
  }
  Use(source, rows, innovation);
  return true;
}

void NavigationFilter::Fuse(const NavMeasurement& measurement) {
  std::visit(
      [&](const auto& data) {
        using T = std::decay_t<decltype(data)>;
        if constexpr (std::is_same_v<T, core::GnssFix>) FuseFix(data, measurement.shift_s);
        if constexpr (std::is_same_v<T, OdometrySample>) FuseOdometry(data);
        if constexpr (std::is_same_v<T, AttitudeSample>) FuseAttitude(data);
      },
      measurement.data);
}

NavigationFilter::TimeOffset NavigationFilter::time_offset() const {
  return {state().time_offset_s, std::sqrt(filter_.covariance()(kTimeOffset, kTimeOffset))};
}

NavigationFilter::TimeOffset NavigationFilter::velocity_delay() const {
  return {state().velocity_delay_s,
          std::sqrt(filter_.covariance()(kVelocityDelay, kVelocityDelay))};
}

void NavigationFilter::WriteNode() {
  if (FilterTape* tape = filter_.tape()) tape->Add(Solution(), filter_.covariance());
}

NavSolution NavigationFilter::Solution() const {
  const NominalState& s = state();
  NavSolution out;
  const BodyMotion motion = Motion();
  out.rate_frd_radps = motion.rate_radps;
  out.time = s.stamp + core::DurationFromSeconds(published_offset_s_);
  const double ahead_s = published_offset_s_ - s.time_offset_s;
  out.position = ahead_s == 0.0 ? s.position : Displaced(s.position, ahead_s * s.velocity_ned_mps);
  out.velocity_ned_mps = s.velocity_ned_mps;
  out.attitude = core::AttitudeFromRotation(s.ned_from_body.toRotationMatrix());
  out.covariance = filter_.covariance().topLeftCorner<9, 9>();
  // The solution is for a GNSS time: what is not known of the offset moves it along its path.
  const auto& p = filter_.covariance();
  const Eigen::Vector3d& v = s.velocity_ned_mps;
  const Eigen::Matrix<double, 9, 1> with_offset = p.block<9, 1>(0, kTimeOffset);
  out.covariance.topRows<3>() -= v * with_offset.transpose();
  out.covariance.leftCols<3>() -= with_offset * v.transpose();
  out.covariance.topLeftCorner<3, 3>() += p(kTimeOffset, kTimeOffset) * v * v.transpose();

  out.gnss_age_s = SecondsSince(last_position_);
  if (hypothesis_) {
    out.state = NavState::kAligning;
    out.reason = NavReason::kHeadingUnknown;
    return out;
  }
  if (out.gnss_age_s <= config_->trust.lost_after_s) {
    out.state = grade_ == GnssGrade::kFixed   ? NavState::kFixed
                : grade_ == GnssGrade::kFloat ? NavState::kFloat
                                              : NavState::kCode;
  } else {
    const bool guided = holding_ || SecondsSince(last_speed_used_) < 1.0 ||
                        (SecondsSince(last_constraint_) < 1.0 && right_.variance < Square(0.3));
    out.state = guided ? NavState::kDeadReckoning : NavState::kInertial;
  }
  if (SecondsSince(last_gap_) < 1.0) {
    out.reason = NavReason::kImuGap;
  } else if (SecondsSince(last_reset_) < 10.0) {
    out.reason = NavReason::kReset;
  } else if (refused_last_) {
    out.reason =
        trust_.on_probation(GnssGrade::kFixed) ? NavReason::kProbation : NavReason::kGnssRefused;
  } else if (out.state <= NavState::kDeadReckoning) {
    out.reason = NavReason::kNoGnss;
  } else {
    out.reason = out.state == NavState::kFixed ? NavReason::kNominal : NavReason::kNotFixed;
  }
  return out;
}

}  // namespace kawara::estimation
