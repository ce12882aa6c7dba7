#pragma once
#include <Eigen/Core>
#include <cstdint>

#include "sim/dice.hpp"
#include "sim/vehicle/random_processes.hpp"
#include "sim/vehicle/sensor_config.hpp"
#include "sim/vehicle/true_inertial.hpp"

namespace kawara::sim {

/// Makes of true inertial data what a real unit says:
///   gyro  = (I + scale + misalignment) rate + G force + bias + instability + walk + white
///   accel = (I + scale + misalignment) force + bias + instability + walk + white
/// limited to its range. Rounding is the packet's business. White noise of a sample of length dt
/// has the standard deviation random walk / sqrt(dt). Source: IEEE Std 952 for the terms and their
/// Allan variances. One thread.
class ImuErrors {
 public:
  ImuErrors(const ImuConfig& config, std::uint64_t seed);

  /// The next sample, of length dt_s.
  Inertial Apply(const Inertial& truth, double dt_s);

  /// Everything that adds to the rate or force whatever it is, as of the last sample (white noise
  /// not counted).
  Eigen::Vector3d gyro_bias_radps() const { return gyro_.Bias(); }
  Eigen::Vector3d accel_bias_mps2() const { return accel_.Bias(); }
  const Eigen::Matrix3d& gyro_gain() const { return gyro_.gain; }    ///< I + scale + misalignment
  const Eigen::Matrix3d& accel_gain() const { return accel_.gain; }  ///< the same
  std::uint64_t saturated() const { return saturated_; }             ///< axes of samples

 private:
  /// Three axes of one kind, SI units.
  struct Triad {
    Eigen::Matrix3d gain;
    Eigen::Vector3d bias;
    double instability;
    GaussMarkov wander;
    double walk;   ///< per sqrt(s)
    double white;  ///< times sqrt(s)
    double range;
    Eigen::Vector3d walked = Eigen::Vector3d::Zero();
    Eigen::Vector3d Bias() const { return bias + instability * wander.value() + walked; }
  };
  Eigen::Vector3d Measure(Triad& triad, const Eigen::Vector3d& truth, double dt_s);

  Dice dice_;
  Triad gyro_, accel_;
  Eigen::Matrix3d gyro_by_force_;  ///< rad/s per m/s^2
  std::uint64_t saturated_ = 0;
};

}  // namespace kawara::sim
