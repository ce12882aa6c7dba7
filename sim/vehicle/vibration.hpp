#pragma once
#include <array>
#include <cstdint>

#include "sim/vehicle/smooth_series.hpp"
#include "sim/vehicle/vehicle_config.hpp"

namespace kawara::sim {

/// Shaking of the body: three independent sums of sines (roll, pitch [rad], heave [m] upwards)
/// whose sizes follow a road of 1/f through the suspension's transfer function, frequencies and
/// phases from the seed. Smooth without end; immutable; any thread. Source: transmissibility of a
/// single mass on spring and damper, any textbook of vibrations.
class Vibration {
 public:
  Vibration(const VibrationConfig& config, std::uint64_t seed);

  struct Shake {
    std::array<double, 3> value{}, d1{}, d2{};  ///< roll, pitch, heave
  };
  /// `gain`: size now (1 at the reference speed) and its derivatives by time.
  Shake At(double t_s, const SmoothSeries::Jet& gain) const;
  /// Size at a speed.
  double GainAt(double speed_mps) const;

 private:
  static constexpr std::size_t kSines = 12;
  struct Sine {
    double rate_radps = 0.0, phase_rad = 0.0, amplitude = 0.0;
  };
  VibrationConfig config_;
  std::array<std::array<Sine, kSines>, 3> axes_{};
};

}  // namespace kawara::sim
