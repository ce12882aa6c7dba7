#include "sim/vehicle/vibration.hpp"

#include <algorithm>
#include <cmath>

#include "core/geodesy.hpp"
#include "sim/dice.hpp"

namespace kawara::sim {

Vibration::Vibration(const VibrationConfig& config, std::uint64_t seed) : config_(config) {
  const std::array<double, 3> rms{config.roll_rms_deg * core::kRadFromDeg,
                                  config.pitch_rms_deg * core::kRadFromDeg, config.heave_rms_m};
  Dice dice(seed);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double sum_squares = 0.0;
    for (std::size_t i = 0; i < kSines; ++i) {
      // One sine in each of equal parts of the band, anywhere in its part: the sum never repeats.
      const double share = (static_cast<double>(i) + dice.Uniform()) / kSines;
      const double hz = config.min_hz + share * (config.max_hz - config.min_hz);
      const double ratio = hz / config.natural_hz;
      const double damped = 2.0 * config.damping * ratio;
      const double transmitted =
          std::sqrt((1.0 + damped * damped) / (std::pow(1.0 - ratio * ratio, 2) + damped * damped));
      Sine& sine = axes_[axis][i];
      sine.rate_radps = 2.0 * core::kPi * hz;
      sine.phase_rad = 2.0 * core::kPi * dice.Uniform();
      sine.amplitude = transmitted / hz;
      sum_squares += 0.5 * sine.amplitude * sine.amplitude;
    }
    for (Sine& sine : axes_[axis]) sine.amplitude *= rms[axis] / std::sqrt(sum_squares);
  }
}

double Vibration::GainAt(double speed_mps) const {
  return std::max(config_.idle_share, std::pow(std::abs(speed_mps) / config_.reference_speed_mps,
                                               config_.speed_exponent));
}

Vibration::Shake Vibration::At(double t_s, const SmoothSeries::Jet& gain) const {
  Shake shake;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double value = 0.0;
    double d1 = 0.0;
    double d2 = 0.0;
    for (const Sine& sine : axes_[axis]) {
      const double angle = sine.rate_radps * t_s + sine.phase_rad;
      const double s = sine.amplitude * std::sin(angle);
      value += s;
      d1 += sine.amplitude * sine.rate_radps * std::cos(angle);
      d2 -= sine.rate_radps * sine.rate_radps * s;
    }
    shake.value[axis] = gain[0] * value;
    shake.d1[axis] = gain[0] * d1 + gain[1] * value;
    shake.d2[axis] = gain[0] * d2 + 2.0 * gain[1] * d1 + gain[2] * value;
  }
  return shake;
}

}  // namespace kawara::sim
