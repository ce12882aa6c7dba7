// Wheels, the vehicle's constraint, the attitude unit, standing still.
#include <algorithm>
#include <cmath>

#include "estimation/chi_square.hpp"
#include "estimation/navigation_filter.hpp"

namespace kawara::estimation {
namespace {

constexpr double kZeroVelocitySd = 0.01;  // m/s
/// Errors of wheels and of the constraint last a while: more often would count them as news.
constexpr double kWheelInterval = 0.095;      // s
constexpr double kConstraintInterval = 0.19;  // s
constexpr double kAhrsInterval = 9.9;         // s
constexpr double kAhrsHeadingTime = 60.0;     // s, steel nearby stays that long
constexpr double kAhrsHeadingWhite = 3.0 * core::kRadFromDeg;
constexpr double kMinSpeed = 0.3;          // m/s: slower, directions mean nothing
constexpr double kConstraintFloor = 0.03;  // m/s
constexpr double kSideslipPerRate = 0.10;  // m/s of sideways motion per rad/s of turning
constexpr double kGateNever = 1e9;
constexpr double kSoften = 6.0;         // NIS of two rows; beyond it the weight falls off
constexpr double kLearning = 0.02;      // share of a new residual: 50 of them
constexpr double kSlipPerSpeed = 0.02;  // wheels: 2 % of the speed
constexpr double kTurnSlip = 0.10;      // wheels: 10 % of the turn rate
constexpr int kSlipsUntilDoubt = 50;

double Square(double v) { return v * v; }

}  // namespace

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
  if (Offer(Source::kSpeed, SpeedRows(state(), motion, sample.speed_mps, sd),
            ChiSquareOneOf1000(1))) {
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
        ChiSquareOneOf1000(1));
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
  MeasurementRows rows = ConstraintRows(state(), motion, right_sd, down_sd);
  // A sudden push sideways is believed less, not refused: what the wheels cannot do stays the best
  // there is, and a filter that refuses it for long drifts away from it for good.
  const double nis = hypothesis_ ? 0.0 : filter_.Predict(rows).nis;
  if (nis > kSoften) rows.noise *= nis / kSoften;
  Offer(Source::kConstraint, rows, kGateNever);
}

void NavigationFilter::FuseAttitude(const AttitudeSample& sample) {
  if (sample.has_heading && sample.heading_sd_rad > 0.0) {
    Offer(Source::kHeading, HeadingRows(state(), sample.attitude.yaw_rad, sample.heading_sd_rad),
          ChiSquareOneOf1000(1));
    return;
  }
  // The unit's own filter drifts slowly about the truth: now and then, and widely, is all it is
  // good for.
  const double dt_s = SecondsSince(last_ahrs_);
  if (dt_s < kAhrsInterval) return;
  last_ahrs_ = state().stamp;
  if (sample.has_level) {
    Offer(Source::kAhrs, LevelRows(state(), sample.attitude, config_->ahrs_level_sd_rad),
          ChiSquareOneOf1000(2));
  }
  if (sample.has_heading) {
    const double variance = Square(config_->ahrs_heading_sd_rad);
    filter_.Decay(kAhrsHeading, {&variance, 1}, std::min(dt_s, 1e4), kAhrsHeadingTime);
    Offer(Source::kAhrs, AhrsHeadingRows(state(), sample.attitude.yaw_rad, kAhrsHeadingWhite),
          ChiSquareOneOf1000(1));
  }
}

}  // namespace kawara::estimation
