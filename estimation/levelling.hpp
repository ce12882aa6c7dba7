#pragma once
#include <Eigen/Core>
#include <optional>

#include "estimation/heading_bank.hpp"
#include "estimation/nav_types.hpp"
#include "estimation/navigation_config.hpp"

namespace kawara::estimation {

/// Before there is a filter: roll, pitch and gyro bias from the samples of the last second,
/// position and velocity from the first fixes, whatever idea of the heading somebody has. One
/// thread.
class Levelling {
 public:
  void Add(const ImuSample& sample);
  /// A start for the heading hypotheses once there is enough.
  std::optional<AlignmentStart> Add(const NavMeasurement& measurement,
                                    const NavigationConfig& config);

 private:
  std::optional<AlignmentStart> OnFix(core::GpsTime stamp, const core::GnssFix& fix,
                                      const NavigationConfig& config);

  int count_ = 0;  ///< samples in the means below, which forget with a second
  double seconds_ = 0.0;
  core::GpsTime last_time_;
  Eigen::Vector3d rate_ = Eigen::Vector3d::Zero();  ///< newest
  Eigen::Vector3d rate_mean_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d rate_var_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_mean_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_var_ = Eigen::Vector3d::Zero();
  std::optional<AttitudeSample> attitude_;
  std::optional<core::GnssFix> fix_before_;
};

}  // namespace kawara::estimation
