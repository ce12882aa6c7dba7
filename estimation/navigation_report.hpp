#pragma once
#include <Eigen/Core>
#include <cstdint>

#include "core/memcpy_safe.hpp"
#include "core/time.hpp"
#include "estimation/nav_types.hpp"

namespace kawara::estimation {

/// How far the solution is to be trusted at one instant: state, accuracy, reason.
struct NavigationReport {
  core::GpsTime time;
  core::MonoTime mono;
  NavState state = NavState::kNone;
  NavReason reason = NavReason::kNoFixYet;
  Eigen::Vector3d position_sd_ned_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_sd_ned_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d attitude_sd_rad = Eigen::Vector3d::Zero();  ///< roll, pitch, yaw
  double gnss_age_s = 0.0;
  double time_offset_s = 0.0;  ///< inertial stamps plus this are GNSS time
  double time_offset_sd_s = 0.0;
  std::int64_t fixes_used = 0;
  std::int64_t fixes_refused = 0;
  std::int64_t wrong_fix_episodes = 0;
  std::int64_t resets = 0;
};

}  // namespace kawara::estimation

template <>
inline constexpr bool kawara::core::kMemcpySafe<kawara::estimation::NavigationReport> = true;
