#pragma once
#include <optional>
#include <string>

#include "core/config/constraints.hpp"
#include "estimation/sensor_profile.hpp"

namespace kawara::estimation {

/// An inertial unit's own figures where somebody knows them: from its data sheet or its Allan
/// deviation, in the units those use. What is not given stays as the profile has it.
struct SensorFigures {
  std::optional<double> angle_walk_deg_per_sqrt_h;     ///< Allan deviation at 1 s x 60
  std::optional<double> velocity_walk_mps_per_sqrt_h;  ///< the same of the accelerometers
  std::optional<double> gyro_bias_degps;               ///< at switching on, 1 sigma
  std::optional<double> accel_bias_mg;
  /// How biases wander afterwards: the floor of the Allan deviation, taken for a Gauss-Markov
  /// process of that deviation and time constant, and the random walk beyond it. With either
  /// given, nothing is left of the profile's wander.
  std::optional<double> gyro_instability_degph;
  std::optional<double> accel_instability_mg;
  std::optional<double> instability_tau_s;  ///< 300 where it is not given
  std::optional<double> gyro_walk_degph_per_sqrt_h;
  std::optional<double> accel_walk_mg_per_sqrt_h;
  std::optional<double> gyro_scale;  ///< share, 1 sigma
  std::optional<double> accel_scale;
  std::optional<double> gyro_misalignment;  ///< share of the other axes, 1 sigma
  std::optional<double> accel_misalignment;
  std::optional<double> gyro_range_degps;  ///< beyond it a sample is a spike
  std::optional<double> accel_range_g;

  template <class V>
  void Visit(V& v) {
    using core::config::Optional;
    using core::config::Range;
    // No unit is without noise, and a filter told so trusts it for ever.
    v("angle_walk_deg_per_sqrt_h", angle_walk_deg_per_sqrt_h, Range{1e-4, 100.0}, Optional{});
    v("velocity_walk_mps_per_sqrt_h", velocity_walk_mps_per_sqrt_h, Range{1e-4, 100.0}, Optional{});
    v("gyro_bias_degps", gyro_bias_degps, Range{1e-6, 20.0}, Optional{});
    v("accel_bias_mg", accel_bias_mg, Range{1e-4, 500.0}, Optional{});
    v("gyro_instability_degph", gyro_instability_degph, Range{0.0, 1e4}, Optional{});
    v("accel_instability_mg", accel_instability_mg, Range{0.0, 100.0}, Optional{});
    v("instability_tau_s", instability_tau_s, Range{1.0, 1e5}, Optional{});
    v("gyro_walk_degph_per_sqrt_h", gyro_walk_degph_per_sqrt_h, Range{0.0, 1e5}, Optional{});
    v("accel_walk_mg_per_sqrt_h", accel_walk_mg_per_sqrt_h, Range{0.0, 1e3}, Optional{});
    v("gyro_scale", gyro_scale, Range{0.0, 0.2}, Optional{});
    v("accel_scale", accel_scale, Range{0.0, 0.2}, Optional{});
    v("gyro_misalignment", gyro_misalignment, Range{0.0, 0.2}, Optional{});
    v("accel_misalignment", accel_misalignment, Range{0.0, 0.2}, Optional{});
    v("gyro_range_degps", gyro_range_degps, Range{10.0, 1e4}, Optional{});
    v("accel_range_g", accel_range_g, Range{1.2, 200.0}, Optional{});
  }
};

/// A file of its own: kawara-navigate --sensor FILE.yaml.
struct SensorFile {
  std::string profile = "ahrs400cc-100";  ///< what is not given below
  SensorFigures figures;

  template <class V>
  void Visit(V& v) {
    v("profile", profile, core::config::OneOf{"ahrs400cc-100", "consumer-mems", "industrial-mems"},
      core::config::Optional{});
    figures.Visit(v);
  }
};

/// The profile's errors with the figures that are given in their place. Source of the wander: a
/// Gauss-Markov process of deviation s and time constant T is driven by white noise of spectral
/// density 2 s^2 / T; for times shorter than T it wanders like a random walk of that density.
ImuNoise WithFigures(const ImuNoise& profile, const SensorFigures& figures);

}  // namespace kawara::estimation
