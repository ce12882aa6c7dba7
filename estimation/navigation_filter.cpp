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
constexpr double kZeroVelocitySd = 0.01;     // m/s
/// Errors of wheels and of the constraint last a while: more often would count them as news.
constexpr double kWheelInterval = 0.095;      // s
constexpr double kConstraintInterval = 0.19;  // s
constexpr double kAhrsInterval = 9.9;         // s
constexpr double kAhrsHeadingTime = 60.0;     // s, steel nearby stays that long
constexpr double kAhrsHeadingWhite = 3.0 * core::kRadFromDeg;
constexpr double kGateOneOf1000[4] = {0.0, 10.8, 13.8, 16.3};  // chi-square, by rows
constexpr double kMinSpeed = 0.3;          // m/s: slower, directions mean nothing
constexpr double kConstraintFloor = 0.03;  // m/s
constexpr double kSideslipPerRate = 0.10;  // m/s of sideways motion per rad/s of turning
constexpr double kLearning = 0.02;         // share of a new residual: 50 of them
constexpr double kSlipPerSpeed = 0.02;     // wheels: 2 % of the speed
constexpr double kTurnSlip = 0.10;         // wheels: 10 % of the turn rate
constexpr int kSlipsUntilDoubt = 50;
/// Wander of slow states, per sqrt(s).
constexpr double kTimeOffsetWander = 2.0e-5;
constexpr double kScaleWander = 2.0e-4;
constexpr double kTurnScaleWander = 2.0e-3;
constexpr double kResetTwice = 60.0;  // s between resets that say the heading is wrong
constexpr double kGravity = 9.8;
constexpr double kLikelihoodCap = 60.0;

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

void NavigationFilter::StopHolding() {
  if (!holding_) return;
  holding_ = false;
  filter_.Turn(held_angle_rad_, held_s_, config_->imu);
  held_angle_rad_.setZero();
  held_s_ = 0.0;
  standstill_.Restart();
}

bool NavigationFilter::SpeedIsZero() const {
  constexpr double kRecent = 0.3;
  if (SecondsSince(last_wheels_) < kRecent) return SecondsSince(wheels_moved_) > kRecent;
  if (SecondsSince(last_velocity_) < 1.5) return gnss_speed_mps_ < gnss_speed_limit_mps_;
  const auto& p = filter_.covariance();
  const double sd = std::sqrt(p(kVelocity, kVelocity) + p(kVelocity + 1, kVelocity + 1));
  return sd < 0.1 && state().velocity_ned_mps.head<2>().norm() < 0.1 + 2.0 * sd;
}

void NavigationFilter::OnBlock(const StandstillDetector::Block& block) {
  if (!block.quiet || !SpeedIsZero() || SecondsSince(last_gap_) < 1.0) {
    StopHolding();
    return;
  }
  Offer(Source::kStandstill, ZeroVelocityRows(state(), kZeroVelocitySd), 50.0);
  if (holding_) {
    // The gyros of this block went into nothing else: their mean is news about their bias.
    const double sd = config_->imu.gyro_arw_rad_rts / std::sqrt(block.duration_s);
    Offer(Source::kStandstill, ZeroRateRows(state(), block.mean_rate_radps, sd), 50.0);
  }
  holding_ = true;
  held_angle_rad_.setZero();
  held_s_ = 0.0;
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

void NavigationFilter::FuseFix(const core::GnssFix& fix, double shift_s) {
  if (fix.has_position) FusePosition(fix, shift_s);
  if (fix.has_velocity) {
    const MeasurementRows rows = GnssVelocityRows(state(), Motion(), fix, shift_s, *config_);
    Offer(Source::kVelocity, rows, config_->trust.velocity_gate);
    last_velocity_ = state().stamp;
    gnss_speed_mps_ = fix.velocity_enu_mps.head<2>().norm();
    gnss_speed_limit_mps_ = std::max(0.06, 1.5 * fix.velocity_sd_enu_mps.head<2>().maxCoeff());
  }
  if (fix.has_heading) {
    Offer(Source::kHeading, HeadingRows(state(), fix.heading_rad, config_->two_antenna_sd_rad),
          kGateOneOf1000[1]);
  }
}

void NavigationFilter::AgePosition(const core::GnssFix& fix, GnssGrade grade) {
  const ColouredShare share = ShareOf(grade, config_->gnss);
  const Eigen::Vector3d variance = Square(share.coloured) * StatedVarianceNed(fix, config_->gnss);
  const double dt_s = SecondsSince(last_coloured_);
  last_coloured_ = state().stamp;
  if (!coloured_set_ || grade != coloured_grade_) {
    // Ambiguities were fixed or lost: what the error was says nothing of what it is.
    coloured_set_ = true;
    coloured_grade_ = grade;
    filter_.SetColoured(Eigen::Vector3d::Zero());
    filter_.Forget(kGnssColoured, variance);
  } else {
    filter_.Decay(kGnssColoured, {variance.data(), 3}, dt_s, share.time_s);
  }
  const double seconds = std::min(dt_s, 10.0);
  if (config_->time_offset_sd_s > 0.0) {
    filter_.Doubt(kTimeOffset, Square(kTimeOffsetWander) * seconds);
  }
  filter_.Doubt(kSpeedScale, Square(kScaleWander) * seconds);
  filter_.Doubt(kTurnScale, Square(kTurnScaleWander) * seconds);
  filter_.Doubt(kMountYaw, Square(0.1 * kScaleWander) * seconds);
  filter_.Doubt(kMountPitch, Square(kScaleWander) * seconds);
}

void NavigationFilter::FusePosition(const core::GnssFix& fix, double shift_s) {
  const GnssGrade grade = GradeOf(fix.rtk);
  const Source source = grade == GnssGrade::kFixed   ? Source::kFixed
                        : grade == GnssGrade::kFloat ? Source::kFloat
                                                     : Source::kCode;
  // The grade's errors are judged without disturbing those of the grade that is believed.
  const ErrorStateFilter undisturbed = filter_;
  const std::uint64_t tape_end = filter_.tape() != nullptr ? filter_.tape()->end() : 0;
  const core::GpsTime aged = last_coloured_;
  const GnssGrade believed = coloured_grade_;
  const bool was_set = coloured_set_;
  AgePosition(fix, grade);
  MeasurementRows rows = PositionRows(state(), Motion(), fix, shift_s, *config_);
  Innovation innovation = filter_.Predict(rows);

  auto& counts = stats_.source[static_cast<std::size_t>(source)];
  ++counts.offered;
  FixTrust::Verdict verdict = FixTrust::Verdict::kUse;
  if (hypothesis_) {
    log_likelihood_ += std::max(-kLikelihoodCap, innovation.LogLikelihood());
  } else {
    const bool refused_before = trust_.refusing(grade);
    const bool drifted = SecondsSince(last_position_) > config_->trust.outage_s &&
                         SecondsSince(last_speed_used_) > 1.0 && !holding_;
    verdict = trust_.Judge(state().stamp, grade, innovation.residual, innovation.nis, drifted,
                           config_->trust);
    if (!refused_before && trust_.refusing(grade)) ++stats_.wrong_fix_episodes;
  }
  refused_last_ = verdict == FixTrust::Verdict::kRefuse;
  if (verdict == FixTrust::Verdict::kRefuse) {
    ++counts.rejected;
    filter_ = undisturbed;
    if (filter_.tape() != nullptr) filter_.tape()->Rewind(tape_end);
    last_coloured_ = aged;
    coloured_grade_ = believed;
    coloured_set_ = was_set;
    return;
  }
  if (verdict == FixTrust::Verdict::kConcede) {
    Concede(innovation);
    rows = PositionRows(state(), Motion(), fix, shift_s, *config_);
    innovation = filter_.Predict(rows);
  }
  Use(source, rows, innovation);
  last_position_ = state().stamp;
  grade_ = grade;
}

void NavigationFilter::Concede(const Innovation& innovation) {
  ++stats_.resets;
  lost_ = lost_ || SecondsSince(last_reset_) < kResetTwice;
  last_reset_ = state().stamp;
  // As wrong as the position became since it was believed last, so may be what moved it there.
  const double seconds = std::clamp(SecondsSince(last_position_), 1.0, 60.0);
  const double miss_m = innovation.residual.norm();
  const double way_m = std::max(1.0, state().velocity_ned_mps.norm() * seconds);
  const double velocity = std::max(0.5, 2.0 * miss_m / seconds);
  const double level = std::clamp(2.0 * miss_m / (kGravity * seconds * seconds),
                                  0.5 * core::kRadFromDeg, 5.0 * core::kRadFromDeg);
  const double yaw = std::clamp(miss_m / way_m, 3.0 * core::kRadFromDeg, 20.0 * core::kRadFromDeg);
  filter_.Doubt(kPosition, innovation.residual.cwiseAbs2() + Eigen::Vector3d::Constant(1.0));
  filter_.Doubt(kVelocity, Eigen::Vector3d::Constant(Square(velocity)));
  filter_.Doubt(kAttitude, {Square(level), Square(level), Square(yaw)});
}

void NavigationFilter::FuseOdometry(const OdometrySample& sample) {
  last_wheels_ = state().stamp;
  if (std::abs(sample.speed_mps) > 0.005 ||
      (sample.has_turn_rate && std::abs(sample.turn_rate_radps) > 0.01)) {
    wheels_moved_ = state().stamp;
    StopHolding();
  }
  if (SecondsSince(last_speed_used_) < kWheelInterval || holding_) return;
  last_speed_used_ = state().stamp;
  const BodyMotion motion = Motion();
  const double sd = std::hypot(config_->odometry_speed_sd_mps, kSlipPerSpeed * sample.speed_mps);
  if (Offer(Source::kSpeed, SpeedRows(state(), motion, sample.speed_mps, sd), kGateOneOf1000[1])) {
    slips_in_row_ = 0;
  } else if (++slips_in_row_ > kSlipsUntilDoubt) {
    slips_in_row_ = 0;  // that is no slip any more: the scale is not what it was
    filter_.Doubt(kSpeedScale, Square(0.05));
  }
  if (!sample.has_turn_rate) return;
  const double turn_sd =
      std::hypot(config_->odometry_turn_sd_radps, kTurnSlip * sample.turn_rate_radps);
  Offer(Source::kTurnRate,
        TurnRateRows(state(), sample_.rate_radps, sample.turn_rate_radps, turn_sd),
        kGateOneOf1000[1]);
}

void NavigationFilter::FuseConstraint() {
  if (config_->constraint == ConstraintMode::kOff || holding_) return;
  if (SecondsSince(last_constraint_) < kConstraintInterval) return;
  const BodyMotion motion = Motion();
  const Eigen::Vector3d vehicle = VehicleVelocity(state(), motion);
  if (std::abs(vehicle.x()) < kMinSpeed) return;
  last_constraint_ = state().stamp;
  // While fixes are good, what is left across the vehicle shows how well it keeps to its direction:
  // hardly for a car, not at all for something carried.
  const bool good = SecondsSince(last_position_) < 0.5 && grade_ == GnssGrade::kFixed;
  const double sideslip = kSideslipPerRate * motion.rate_radps.z();
  if (good) {
    right_.Add(vehicle.y(), kLearning);
    down_.Add(vehicle.z(), kLearning);
  }
  const double right_sd =
      std::sqrt(std::max(Square(kConstraintFloor), right_.variance) + Square(sideslip));
  const double down_sd = std::sqrt(std::max(Square(kConstraintFloor), down_.variance));
  Offer(Source::kConstraint, ConstraintRows(state(), motion, right_sd, down_sd), kGateOneOf1000[2]);
}

void NavigationFilter::FuseAttitude(const AttitudeSample& sample) {
  if (sample.has_heading && sample.heading_sd_rad > 0.0) {
    Offer(Source::kHeading, HeadingRows(state(), sample.attitude.yaw_rad, sample.heading_sd_rad),
          kGateOneOf1000[1]);
    return;
  }
  // The unit's own filter drifts slowly about the truth: now and then, and widely, is all it is
  // good for.
  const double dt_s = SecondsSince(last_ahrs_);
  if (dt_s < kAhrsInterval) return;
  last_ahrs_ = state().stamp;
  if (sample.has_level) {
    Offer(Source::kAhrs, LevelRows(state(), sample.attitude, config_->ahrs_level_sd_rad),
          kGateOneOf1000[2]);
  }
  if (sample.has_heading) {
    const double variance = Square(config_->ahrs_heading_sd_rad);
    filter_.Decay(kAhrsHeading, {&variance, 1}, std::min(dt_s, 1e4), kAhrsHeadingTime);
    Offer(Source::kAhrs, AhrsHeadingRows(state(), sample.attitude.yaw_rad, kAhrsHeadingWhite),
          kGateOneOf1000[1]);
  }
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
