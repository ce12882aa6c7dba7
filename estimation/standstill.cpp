#include "estimation/standstill.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::estimation {
namespace {

constexpr double kBlock = 0.25;
constexpr int kMinSamples = 5;
/// A unit at rest still trembles a little with whatever it is mounted on.
constexpr double kRateTremor = 0.004;  // rad/s
constexpr double kForceTremor = 0.04;  // m/s^2
/// Mean force of one block against the next: leaning and accelerating show here.
constexpr double kForceChange = 0.05;  // m/s^2
constexpr double kSigmas = 3.0;

double Square(double v) { return v * v; }

}  // namespace

void StandstillDetector::Restart() { *this = {}; }

bool StandstillDetector::Stirs(const ImuSample& sample, double dt_s,
                               const Eigen::Vector3d& expected_rate_radps, const ImuNoise& noise) {
  const double sample_sd = noise.gyro_arw_rad_rts / std::sqrt(std::max(dt_s, 1e-4));
  const double limit = 5.0 * std::hypot(sample_sd, kRateTremor);
  return (sample.rate_radps - expected_rate_radps).cwiseAbs().maxCoeff() > limit;
}

std::optional<StandstillDetector::Block> StandstillDetector::Add(
    const ImuSample& sample, double dt_s, const Eigen::Vector3d& expected_rate_radps,
    double bias_sd_radps, const ImuNoise& noise) {
  ++count_;
  duration_s_ += dt_s;
  // Sums about the expectation: squares of small numbers.
  const Eigen::Vector3d rate = sample.rate_radps - expected_rate_radps;
  rate_sum_ += rate;
  rate_squares_ += rate.cwiseAbs2();
  force_sum_ += sample.specific_force_mps2;
  force_squares_ += sample.specific_force_mps2.cwiseAbs2();
  if (duration_s_ < kBlock - 0.5 * dt_s || count_ < kMinSamples) return std::nullopt;

  const double n = count_;
  const double mean_dt = duration_s_ / n;
  const Eigen::Vector3d rate_mean = rate_sum_ / n;
  const Eigen::Vector3d force_mean = force_sum_ / n;
  const Eigen::Vector3d rate_var = rate_squares_ / n - rate_mean.cwiseAbs2();
  const Eigen::Vector3d force_var = force_squares_ / n - force_mean.cwiseAbs2();
  // The Earth's rotation is in the mean as well.
  constexpr double kEarthRate = 7.3e-5;
  const double mean_limit =
      kSigmas * std::hypot(bias_sd_radps, noise.gyro_arw_rad_rts / std::sqrt(duration_s_)) +
      kEarthRate + 0.25 * kRateTremor;
  const double rate_limit =
      std::hypot(kSigmas * noise.gyro_arw_rad_rts / std::sqrt(mean_dt), kSigmas * kRateTremor);
  const double force_limit =
      std::hypot(kSigmas * noise.accel_vrw_mps_rts / std::sqrt(mean_dt), kSigmas * kForceTremor);
  const double change_limit =
      kForceChange + kSigmas * noise.accel_vrw_mps_rts * std::sqrt(2.0 / duration_s_);

  Block block;
  block.duration_s = duration_s_;
  block.mean_rate_radps = rate_mean + expected_rate_radps;
  block.mean_force_mps2 = force_mean;
  block.quiet = rate_mean.cwiseAbs().maxCoeff() < mean_limit &&
                rate_var.maxCoeff() < Square(rate_limit) &&
                force_var.maxCoeff() < Square(force_limit) &&
                (!has_before_ || (force_mean - force_before_).cwiseAbs().maxCoeff() < change_limit);
  Restart();
  force_before_ = block.mean_force_mps2;
  has_before_ = true;
  return block;
}

}  // namespace kawara::estimation
