#include "sim/vehicle/imu_errors.hpp"

#include <algorithm>
#include <cmath>

#include "core/geodesy.hpp"

namespace kawara::sim {
namespace {

constexpr double kG_mps2 = 9.80665;
constexpr double kMilliG_mps2 = 1e-3 * kG_mps2;
constexpr double kRadpsFromDegph = core::kRadFromDeg / 3600.0;
constexpr double kPerSqrtS = 1.0 / 60.0;  ///< of something per square root of an hour

Eigen::Matrix3d DrawMatrix(double on_diagonal, double off_diagonal, Dice& dice) {
  Eigen::Matrix3d m;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      m(row, column) = (row == column ? on_diagonal : off_diagonal) * DrawnNormal(dice);
  }
  return m;
}

}  // namespace

ImuErrors::ImuErrors(const ImuConfig& c, std::uint64_t seed)
    : dice_(seed),
      gyro_{Eigen::Matrix3d::Identity() + DrawMatrix(c.gyro_scale, c.gyro_misalignment, dice_),
            c.gyro_bias_degps * core::kRadFromDeg * DrawnVector(dice_),
            c.gyro_instability_degph * kRadpsFromDegph,
            GaussMarkov(c.gyro_instability_tau_s, dice_),
            c.gyro_walk_degph_per_sqrt_h * kRadpsFromDegph * kPerSqrtS,
            c.angle_walk_deg_per_sqrt_h * core::kRadFromDeg * kPerSqrtS,
            c.gyro_range_degps * core::kRadFromDeg},
      accel_{Eigen::Matrix3d::Identity() + DrawMatrix(c.accel_scale, c.accel_misalignment, dice_),
             c.accel_bias_mg * kMilliG_mps2 * DrawnVector(dice_),
             c.accel_instability_mg * kMilliG_mps2,
             GaussMarkov(c.accel_instability_tau_s, dice_),
             c.accel_walk_mg_per_sqrt_h * kMilliG_mps2 * kPerSqrtS,
             c.velocity_walk_mps_per_sqrt_h * kPerSqrtS,
             c.accel_range_g * kG_mps2},
      gyro_by_force_(DrawMatrix(1.0, 1.0, dice_) * c.gyro_g_degps_per_g * core::kRadFromDeg /
                     kG_mps2) {}

Eigen::Vector3d ImuErrors::Measure(Triad& triad, const Eigen::Vector3d& truth, double dt_s) {
  triad.wander.Step(dt_s, dice_);
  triad.walked += triad.walk * std::sqrt(dt_s) * NormalVector(dice_);
  Eigen::Vector3d measured =
      triad.gain * truth + triad.Bias() + triad.white / std::sqrt(dt_s) * NormalVector(dice_);
  for (double& axis : measured) {
    const double limited = std::clamp(axis, -triad.range, triad.range);
    if (limited != axis) ++saturated_;
    axis = limited;
  }
  return measured;
}

Inertial ImuErrors::Apply(const Inertial& truth, double dt_s) {
  // The gyro's own gain does not apply to what the force does to it.
  const Eigen::Vector3d by_force = gyro_by_force_ * truth.specific_force_mps2;
  Inertial out;
  out.rate_radps = Measure(gyro_, truth.rate_radps + gyro_.gain.inverse() * by_force, dt_s);
  out.specific_force_mps2 = Measure(accel_, truth.specific_force_mps2, dt_s);
  return out;
}

}  // namespace kawara::sim
