#include "estimation/sample_gate.hpp"

#include <cmath>

namespace kawara::estimation {
namespace {

constexpr int kMaxBackwards = 50;
constexpr double kGap = 0.1;  // s
/// No vehicle does this from one sample to the next and back; a bit error does.
constexpr double kForceJump = 40.0;  // m/s^2
constexpr double kRateJump = 6.0;    // rad/s

bool Jumps(const ImuSample& a, const ImuSample& b, double share) {
  return (a.specific_force_mps2 - b.specific_force_mps2).cwiseAbs().maxCoeff() >
             share * kForceJump ||
         (a.rate_radps - b.rate_radps).cwiseAbs().maxCoeff() > share * kRateJump;
}

bool InRange(const ImuSample& sample, const ImuNoise& noise) {
  return sample.rate_radps.allFinite() && sample.specific_force_mps2.allFinite() &&
         sample.rate_radps.cwiseAbs().maxCoeff() <= noise.gyro_range_radps &&
         sample.specific_force_mps2.cwiseAbs().maxCoeff() <= noise.accel_range_mps2;
}

}  // namespace

SampleGate::Result SampleGate::Pass(ImuSample& sample, const ImuNoise& noise,
                                    NavigationStats& stats) {
  if (!InRange(sample, noise) || !sample.time.IsSet()) {
    ++stats.imu_invalid;
    return Result::kDrop;
  }
  if (!has_last_) {
    has_last_ = true;
    last_ = sample;
    return Result::kPass;
  }
  if (sample.time == last_.time) {
    ++stats.imu_duplicates;
    return Result::kDrop;
  }
  if (sample.time < last_.time) {
    ++stats.imu_backwards;
    if (++backwards_in_row_ < kMaxBackwards) return Result::kDrop;
    backwards_in_row_ = 0;
    has_suspect_ = false;
    last_ = sample;
    return Result::kRestart;
  }
  backwards_in_row_ = 0;
  const double dt_s = core::ToSeconds(sample.time - last_.time);
  if (dt_s > kGap) {
    ++stats.imu_gaps;
  } else if (Jumps(sample, last_, 1.0) && !(has_suspect_ && !Jumps(sample, suspect_, 0.5))) {
    ++stats.imu_spikes;
    suspect_ = sample;
    has_suspect_ = true;
    sample.rate_radps = last_.rate_radps;
    sample.specific_force_mps2 = last_.specific_force_mps2;
    last_.time = sample.time;
    return Result::kPass;
  }
  has_suspect_ = false;
  last_ = sample;
  return Result::kPass;
}

}  // namespace kawara::estimation
