#include "vision/auto_exposure.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::vision {
namespace {

/// A picture that is white or black for the most part tells no more than the direction.
constexpr double kMostlySaturated = 0.5;
constexpr double kDarkest = 0.002;
constexpr double kLeap = 6.0;

}  // namespace

AutoExposure::AutoExposure(const AutoExposureConfig& config, const ExposureSetting& begin)
    : config_(config), setting_(begin) {}

double AutoExposure::Ratio(const LightHistogram& light) {
  const double mean = light.TrimmedMean(config_.response_gamma);
  if (light.SaturatedShare() > kMostlySaturated || mean < kDarkest) {
    correcting_ = true;
    return mean < kDarkest ? kLeap : 1.0 / kLeap;
  }
  const double wanted = config_.target / mean;
  return IsRight(wanted) ? 1.0 : std::pow(wanted, kEagerness);
}

bool AutoExposure::IsRight(double wanted) {
  const double error = std::abs(wanted - 1.0);
  const bool brighter = wanted > 1.0;
  const bool near = error <= 2.0 * config_.dead_band;
  // Right, or just past it on the other side.
  if (error <= config_.dead_band || (near && brighter != brighter_)) correcting_ = false;
  if (!near) correcting_ = true;
  brighter_ = brighter;
  return !correcting_;
}

ExposureSetting AutoExposure::Split(double product) const {
  ExposureSetting setting;
  const double exposure_s = std::clamp(product, config_.min_exposure_s, config_.max_exposure_s);
  const double steps = exposure_s / config_.exposure_step_s;
  constexpr double kAsGoodAsWhole = 1e-6;
  const double whole =
      config_.max_gain > 1.0 ? std::floor(steps + kAsGoodAsWhole) : std::round(steps);
  setting.exposure_s = std::max(whole, 1.0) * config_.exposure_step_s;
  setting.gain = std::clamp(product / setting.exposure_s, 1.0, config_.max_gain);
  return setting;
}

std::optional<ExposureSetting> AutoExposure::Next(const LightHistogram& light,
                                                  core::MonoTime exposed) {
  if (light.total == 0 || exposed < settled_) return std::nullopt;
  const double ratio = Ratio(light);
  if (ratio == 1.0) return std::nullopt;
  const ExposureSetting next = Split(setting_.product() * ratio);
  constexpr double kSame = 0.01;
  const bool at_a_limit = std::abs(next.product() / setting_.product() - 1.0) < kSame;
  if (at_a_limit) return std::nullopt;
  return next;
}

void AutoExposure::OnSet(const ExposureSetting& setting, core::MonoTime now) {
  setting_ = setting;
  settled_ = now + core::DurationFromSeconds(config_.settle_s);
}

}  // namespace kawara::vision
