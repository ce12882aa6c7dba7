#pragma once
#include <cmath>
#include <cstdint>

#include "sim/dice.hpp"
#include "sim/vehicle/sensor_config.hpp"

namespace kawara::sim {

/// When an instrument that counts its own periods really samples. Its crystal is `skew_ppm` fast
/// (so its periods are short), and that wanders like a random walk. One thread.
class InstrumentClock {
 public:
  InstrumentClock(const InstrumentClockConfig& config, double period_s, std::uint64_t seed)
      : config_(config), period_s_(period_s), skew_ppm_(config.skew_ppm), dice_(seed) {
    true_s_ = period_s * dice_.Uniform();  // the sampling's phase is nobody's
    stamp_s_ = true_s_ + config.offset_s;
  }
  /// To the next sample.
  void Next() {
    skew_ppm_ += config_.wander_ppm_per_sqrt_h * std::sqrt(period_s_ / 3600.0) * dice_.Normal();
    true_s_ += period_s_ / (1.0 + skew_ppm_ * 1e-6);
    stamp_s_ += period_s_;
  }
  double true_s() const { return true_s_; }    ///< of this sample
  double stamp_s() const { return stamp_s_; }  ///< of this sample, by the instrument
  double period_s() const { return period_s_ / (1.0 + skew_ppm_ * 1e-6); }  ///< true

 private:
  InstrumentClockConfig config_;
  double period_s_;
  double skew_ppm_;
  Dice dice_;
  double true_s_ = 0.0;
  double stamp_s_ = 0.0;
};

}  // namespace kawara::sim
