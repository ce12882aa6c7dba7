#pragma once
#include <Eigen/Core>
#include <optional>

#include "estimation/nav_types.hpp"
#include "estimation/sensor_profile.hpp"

namespace kawara::estimation {

/// Looks at inertial samples in blocks of a quarter second: does the unit lie still? Quiet is
/// measured against the unit's own noise. Quiet is not yet standing still (a smooth ride is quiet,
/// too): who asks needs a word about the speed as well. Copyable. One thread.
class StandstillDetector {
 public:
  struct Block {
    bool quiet = false;
    double duration_s = 0.0;
    Eigen::Vector3d mean_rate_radps = Eigen::Vector3d::Zero();
    Eigen::Vector3d mean_force_mps2 = Eigen::Vector3d::Zero();
  };

  /// A block when one is full. `expected_rate_radps`: the gyro bias as known, with `bias_sd_radps`.
  std::optional<Block> Add(const ImuSample& sample, double dt_s,
                           const Eigen::Vector3d& expected_rate_radps, double bias_sd_radps,
                           const ImuNoise& noise);
  /// This one sample alone says that the unit moves.
  static bool Stirs(const ImuSample& sample, double dt_s,
                    const Eigen::Vector3d& expected_rate_radps, const ImuNoise& noise);
  void Restart();

 private:
  int count_ = 0;
  double duration_s_ = 0.0;
  Eigen::Vector3d rate_sum_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d rate_squares_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_sum_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_squares_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_before_ = Eigen::Vector3d::Zero();  ///< mean of the block before
  bool has_before_ = false;
};

}  // namespace kawara::estimation
