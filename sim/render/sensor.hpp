#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "core/config/constraints.hpp"

namespace kawara::sim {

/// The chip behind the lens.
struct SensorSettings {
  double full_well_e = 9000.0;  ///< electrons of a pixel that is just white; 0: no noise at all
  double read_noise_e = 12.0;   ///< standard deviation of a dark pixel [electrons]
  /// Exposure: linear light times gain is the signal, 1 is white. Automatic: the mean of what is
  /// seen comes to `target`, each frame for itself, within gain_min..gain_max; what white clips
  /// then clips.
  bool automatic = true;
  double target = 0.22;
  double gain = 0.9;  ///< when not automatic
  double gain_min = 0.05;
  double gain_max = 20.0;

  template <class V>
  void Visit(V& v) {
    using core::config::Optional;
    using core::config::Range;
    v("full_well_e", full_well_e, Range{0, 1e6}, Optional{});
    v("read_noise_e", read_noise_e, Range{0, 1e4}, Optional{});
    v("automatic", automatic, Optional{});
    v("target", target, Range{0.01, 0.9}, Optional{});
    v("gain", gain, Range{0.001, 1000}, Optional{});
    v("gain_min", gain_min, Range{0.001, 1000}, Optional{});
    v("gain_max", gain_max, Range{0.001, 1000}, Optional{});
  }
};

/// Light to bytes: shot noise (variance equal to the electrons), read noise, clipping, sRGB curve.
/// The noise of a pixel follows from (seed, pixel) alone, so it does not matter who computes it
/// when. A high gain makes the same light fewer electrons: dark scenes are noisier. Immutable; any
/// thread.
class Sensor {
 public:
  explicit Sensor(const SensorSettings& settings);

  /// Gain for a frame whose mean linear light is `mean_light`.
  double GainFor(double mean_light) const;
  /// One colour pixel; `signal` is light times gain, three channels.
  void Expose(const std::array<float, 3>& signal, std::uint64_t frame_seed,
              std::uint32_t pixel_index, std::uint8_t* rgb) const;

 private:
  SensorSettings settings_;
  float inverse_well_ = 0.0F;
  float read_share_squared_ = 0.0F;
  std::vector<float> normal_;       ///< quantiles of the normal distribution
  std::vector<std::uint8_t> srgb_;  ///< of linear values in steps
};

}  // namespace kawara::sim
