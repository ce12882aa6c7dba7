#include "estimation/sensor_figures.hpp"

#include <cmath>

#include "core/geodesy.hpp"

namespace kawara::estimation {
namespace {

constexpr double kHour = 3600.0;        // s
constexpr double kRootHour = 60.0;      // sqrt(s)
constexpr double kMilliG = 9.80665e-3;  // m/s^2
constexpr double kUsualTau = 300.0;     // s

void Put(double& field, const std::optional<double>& figure, double unit) {
  if (figure) field = *figure * unit;
}

void PutWander(double& field, const std::optional<double>& instability, double instability_unit,
               double tau_s, const std::optional<double>& walk, double walk_unit) {
  if (!instability && !walk) return;
  field = std::hypot(instability.value_or(0.0) * instability_unit * std::sqrt(2.0 / tau_s),
                     walk.value_or(0.0) * walk_unit);
}

}  // namespace

ImuNoise WithFigures(const ImuNoise& profile, const SensorFigures& figures) {
  constexpr double kDegree = core::kRadFromDeg;
  const double tau_s = figures.instability_tau_s.value_or(kUsualTau);
  ImuNoise noise = profile;
  Put(noise.gyro_arw_rad_rts, figures.angle_walk_deg_per_sqrt_h, kDegree / kRootHour);
  Put(noise.accel_vrw_mps_rts, figures.velocity_walk_mps_per_sqrt_h, 1.0 / kRootHour);
  Put(noise.gyro_bias_radps, figures.gyro_bias_degps, kDegree);
  Put(noise.accel_bias_mps2, figures.accel_bias_mg, kMilliG);
  PutWander(noise.gyro_bias_rw, figures.gyro_instability_degph, kDegree / kHour, tau_s,
            figures.gyro_walk_degph_per_sqrt_h, kDegree / kHour / kRootHour);
  PutWander(noise.accel_bias_rw, figures.accel_instability_mg, kMilliG, tau_s,
            figures.accel_walk_mg_per_sqrt_h, kMilliG / kRootHour);
  Put(noise.gyro_scale, figures.gyro_scale, 1.0);
  Put(noise.accel_scale, figures.accel_scale, 1.0);
  Put(noise.gyro_misalignment, figures.gyro_misalignment, 1.0);
  Put(noise.accel_misalignment, figures.accel_misalignment, 1.0);
  Put(noise.gyro_range_radps, figures.gyro_range_degps, kDegree);
  Put(noise.accel_range_mps2, figures.accel_range_g, 1e3 * kMilliG);
  return noise;
}

}  // namespace kawara::estimation
