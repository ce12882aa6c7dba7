#include "estimation/levelling.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "estimation/local_frame.hpp"
#include "estimation/measurement_models.hpp"

namespace kawara::estimation {
namespace {

constexpr double kMemory = 1.0;       // s
constexpr double kEnough = 0.5;       // s of samples
constexpr double kStillForce = 0.25;  // m/s^2, spread of a body at rest with its engine running
constexpr double kStillRate = 0.03;   // rad/s
constexpr double kStillSpeed = 0.15;  // m/s
constexpr double kMovingLevelSd = 5.0 * core::kRadFromDeg;  // accelerating 0.9 m/s^2
constexpr double kLongestPair = 2.5;  // s between two fixes that give a velocity
constexpr double kGravity = 9.80665;

}  // namespace

void Levelling::Add(const ImuSample& sample) {
  const double dt_s = last_time_.IsSet() ? core::ToSeconds(sample.time - last_time_) : 0.01;
  last_time_ = sample.time;
  rate_ = sample.rate_radps;
  ++count_;
  seconds_ += dt_s;
  const double share = std::max(1.0 / count_, std::min(1.0, dt_s / kMemory));
  const Eigen::Vector3d rate = sample.rate_radps - rate_mean_;
  const Eigen::Vector3d force = sample.specific_force_mps2 - force_mean_;
  rate_mean_ += share * rate;
  force_mean_ += share * force;
  rate_var_ = (1.0 - share) * (rate_var_ + share * rate.cwiseAbs2());
  force_var_ = (1.0 - share) * (force_var_ + share * force.cwiseAbs2());
}

std::optional<AlignmentStart> Levelling::Add(const NavMeasurement& measurement,
                                             const NavigationConfig& config) {
  if (const auto* attitude = std::get_if<AttitudeSample>(&measurement.data)) attitude_ = *attitude;
  const auto* fix = std::get_if<core::GnssFix>(&measurement.data);
  if (fix == nullptr || !fix->has_position) return std::nullopt;
  auto start = OnFix(measurement.stamp, *fix, config);
  fix_before_ = *fix;
  return start;
}

std::optional<AlignmentStart> Levelling::OnFix(core::GpsTime stamp, const core::GnssFix& fix,
                                               const NavigationConfig& config) {
  if (seconds_ < kEnough) return std::nullopt;
  AlignmentStart start;
  start.stamp = stamp;
  start.antenna = fix.antenna;
  start.rate_radps = rate_;
  start.position_sd_ned_m = 1.5 * StatedVarianceNed(fix, config.gnss).cwiseSqrt();
  if (fix.has_velocity) {
    start.velocity_ned_mps = NedFromEnu(fix.velocity_enu_mps);
    start.velocity_sd_mps = std::max(0.2, 2.0 * fix.velocity_sd_enu_mps.maxCoeff());
  } else {
    if (!fix_before_) return std::nullopt;
    const double dt_s = core::ToSeconds(fix.time - fix_before_->time);
    if (dt_s <= 0.0 || dt_s > kLongestPair) return std::nullopt;
    start.velocity_ned_mps = Displacement(fix_before_->antenna, fix.antenna) / dt_s;
    start.velocity_sd_mps = std::hypot(0.3 + 0.5 * dt_s, start.position_sd_ned_m.maxCoeff() / dt_s);
  }
  const bool still = std::sqrt(force_var_.maxCoeff()) < kStillForce &&
                     std::sqrt(rate_var_.maxCoeff()) < kStillRate &&
                     rate_mean_.cwiseAbs().maxCoeff() < 3.0 * config.imu.gyro_bias_radps &&
                     start.velocity_ned_mps.norm() < kStillSpeed + start.velocity_sd_mps;
  const Eigen::Vector3d& f = force_mean_;
  start.roll_rad = std::atan2(-f.y(), -f.z());
  start.pitch_rad = std::atan2(f.x(), std::hypot(f.y(), f.z()));
  start.level_sd_rad = kMovingLevelSd;
  start.gyro_bias_sd_radps = config.imu.gyro_bias_radps;
  if (still) {
    start.level_sd_rad = std::hypot(0.5 * core::kRadFromDeg, config.imu.accel_bias_mps2 / kGravity);
    start.gyro_bias_radps = rate_mean_;
    start.gyro_bias_sd_radps =
        std::min(config.imu.gyro_bias_radps,
                 0.1 * core::kRadFromDeg + config.imu.gyro_arw_rad_rts / std::sqrt(kEnough));
  } else if (attitude_ && attitude_->has_level) {
    start.roll_rad = attitude_->attitude.roll_rad;
    start.pitch_rad = attitude_->attitude.pitch_rad;
    start.level_sd_rad = 1.5 * config.ahrs_level_sd_rad;
  }
  if (fix.has_heading) {
    start.heading_rad = fix.heading_rad;
    start.heading_sd_rad = config.two_antenna_sd_rad;
  } else if (attitude_ && attitude_->has_heading) {
    start.heading_rad = attitude_->attitude.yaw_rad;
    start.heading_sd_rad =
        attitude_->heading_sd_rad > 0.0 ? attitude_->heading_sd_rad : config.ahrs_heading_sd_rad;
  }
  return start;
}

}  // namespace kawara::estimation
