#include "estimation/heading_bank.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "estimation/local_frame.hpp"

namespace kawara::estimation {
namespace {

constexpr double kSpacing = 2.0 * core::kPi / HeadingBank::kHypotheses;
/// Neighbours overlap: 0.45 of the spacing.
constexpr double kHypothesisSd = 0.45 * kSpacing;
/// Decided when the whole mixture is narrower than this.
constexpr double kDecided = 4.0 * core::kRadFromDeg;
/// Even a good idea of the heading may be wrong: magnetic headings beside steel are.
constexpr double kIdeaFloor = 0.02;

double Square(double v) { return v * v; }

ErrorCovariance StartCovariance(const AlignmentStart& start, const NavigationConfig& config) {
  const ImuNoise& imu = config.imu;
  ErrorVector sd = ErrorVector::Zero();
  sd.segment<3>(kPosition) = start.position_sd_ned_m;
  sd.segment<3>(kVelocity).setConstant(start.velocity_sd_mps);
  sd.segment<2>(kAttitude).setConstant(start.level_sd_rad);
  sd(kAttitude + 2) = kHypothesisSd;
  sd.segment<3>(kGyroBias).setConstant(start.gyro_bias_sd_radps);
  sd.segment<3>(kAccelBias).setConstant(imu.accel_bias_mps2);
  sd.segment<3>(kGyroScale).setConstant(imu.gyro_scale);
  sd.segment<3>(kAccelScale).setConstant(imu.accel_scale);
  sd(kTimeOffset) = config.time_offset_sd_s;
  sd(kVelocityDelay) = config.gnss.velocity_delay_sd_s;
  sd(kSpeedScale) = config.odometry_speed_scale_sd;
  sd(kTurnScale) = config.odometry_turn_scale_sd;
  sd(kMountPitch) = config.mount_sd_rad;
  sd(kMountYaw) = config.mount_sd_rad;
  sd(kAxle) = config.axle_sd_m;
  sd(kAhrsHeading) = config.ahrs_heading_sd_rad;
  sd(kSquat) = config.squat_sd_rad_per_mps2;
  sd(kSideslip) = config.sideslip_sd_rad_per_mps2;
  sd.segment<2>(kGyroCross).setConstant(imu.gyro_misalignment);
  return sd.cwiseAbs2().asDiagonal();
}

/// What stays as it is when a robot is switched off and on: each error's own variance, four times
/// as large.
void KeepCalibration(const ErrorCovariance& learned, ErrorCovariance& covariance) {
  constexpr double kDoubt = 4.0;
  for (int i = kGyroBias; i < kErrorStates; ++i) {
    const bool momentary = (i >= kGnssColoured && i < kTimeOffset) || i == kAhrsHeading;
    if (!momentary) covariance(i, i) = std::min(covariance(i, i), kDoubt * learned(i, i));
  }
}

/// The covariance of a body whose antenna's position and velocity have those of `antenna`.
ErrorCovariance FromAntenna(const ErrorCovariance& antenna, const Eigen::Vector3d& arm_ned_m,
                            const Eigen::Vector3d& sway_ned_mps) {
  const Eigen::Matrix3d of_arm = CrossMatrix(arm_ned_m), of_sway = CrossMatrix(sway_ned_mps);
  ErrorCovariance body = antenna;
  const auto add = [&](int first, const Eigen::Matrix3d& by_attitude) {
    body.middleRows<3>(first) += by_attitude * body.middleRows<3>(kAttitude);
    body.middleCols<3>(first) += body.middleCols<3>(kAttitude) * by_attitude.transpose();
  };
  add(kPosition, of_arm);
  add(kVelocity, of_sway);
  return body;
}

}  // namespace

HeadingBank::HeadingBank(const NavigationConfig& config) : config_(&config) {
  filters_.reserve(kHypotheses);
  prior_.reserve(kHypotheses);
}

void HeadingBank::Start(const AlignmentStart& start, const NavigationFilter* calibrated) {
  filters_.clear();
  prior_.clear();
  ErrorCovariance covariance = StartCovariance(start, *config_);
  if (calibrated != nullptr) KeepCalibration(calibrated->errors().covariance(), covariance);
  for (int i = 0; i < kHypotheses; ++i) {
    NominalState state;
    if (calibrated != nullptr) state = calibrated->state();
    state.gnss_coloured_ned_m.setZero();
    state.ahrs_heading_rad = 0.0;
    state.stamp = start.stamp;
    const double yaw_rad = core::WrapPi(kSpacing * i);
    const Eigen::Matrix3d ned_from_body =
        core::RotationNedFromBody({start.roll_rad, start.pitch_rad, yaw_rad});
    state.ned_from_body = Eigen::Quaterniond(ned_from_body);
    if (calibrated == nullptr) state.gyro_bias_radps = start.gyro_bias_radps;
    // What is known is the antenna. The body is where the attitude puts it, errors and all: were
    // they taken for independent, the next fix would pass for news of the attitude.
    const Eigen::Vector3d arm = ned_from_body * config_->lever_arm_frd_m;
    const Eigen::Vector3d sway =
        ned_from_body * state.TrueRate(start.rate_radps).cross(config_->lever_arm_frd_m);
    state.position = Displaced(start.antenna, -arm);
    state.velocity_ned_mps = start.velocity_ned_mps - sway;
    filters_.emplace_back(*config_, state, FromAntenna(covariance, arm, sway));
    filters_.back().SetHypothesis(true);
    double weight = 1.0;
    if (start.heading_rad) {
      const double miss = core::WrapPi(yaw_rad - *start.heading_rad);
      weight =
          std::exp(-0.5 * Square(miss) / (Square(start.heading_sd_rad) + Square(kHypothesisSd)));
      weight += kIdeaFloor;
    }
    prior_.push_back(std::log(weight));
  }
  running_ = true;
}

void HeadingBank::Advance(const ImuSample& sample, core::GpsTime stamp) {
  for (auto& filter : filters_) filter.Advance(sample, stamp);
}

void HeadingBank::FinishSample(const ImuSample& sample) {
  for (auto& filter : filters_) filter.FinishSample(sample);
}

void HeadingBank::Fuse(const NavMeasurement& measurement) {
  for (auto& filter : filters_) filter.Fuse(measurement);
}

HeadingBank::Mixture HeadingBank::Mix() const {
  std::array<double, kHypotheses> weight{};
  int best = 0;
  const auto log_weight = [&](int i) {
    return filters_[static_cast<std::size_t>(i)].log_likelihood() +
           prior_[static_cast<std::size_t>(i)];
  };
  for (int i = 1; i < kHypotheses; ++i) {
    if (log_weight(i) > log_weight(best)) best = i;
  }
  const auto yaw = [&](int i) {
    return core::AttitudeFromRotation(
               filters_[static_cast<std::size_t>(i)].state().ned_from_body.toRotationMatrix())
        .yaw_rad;
  };
  const double best_yaw_rad = yaw(best);
  double sum = 0.0, mean = 0.0, square = 0.0;
  for (int i = 0; i < kHypotheses; ++i) {
    auto& w = weight[static_cast<std::size_t>(i)];
    w = std::exp(log_weight(i) - log_weight(best));
    const double off = core::WrapPi(yaw(i) - best_yaw_rad);
    const double variance =
        filters_[static_cast<std::size_t>(i)].errors().covariance()(kAttitude + 2, kAttitude + 2);
    sum += w;
    mean += w * off;
    square += w * (variance + off * off);
  }
  mean /= sum;
  return {best, std::sqrt(std::max(0.0, square / sum - mean * mean))};
}

const NavigationFilter* HeadingBank::Winner() const {
  if (!running_) return nullptr;
  const Mixture mixture = Mix();
  if (mixture.heading_sd_rad > kDecided) return nullptr;
  return &filters_[static_cast<std::size_t>(mixture.best)];
}

NavSolution HeadingBank::Solution() const {
  const Mixture mixture = Mix();
  NavSolution solution = filters_[static_cast<std::size_t>(mixture.best)].Solution();
  solution.covariance(kAttitude + 2, kAttitude + 2) = Square(mixture.heading_sd_rad);
  return solution;
}

}  // namespace kawara::estimation
