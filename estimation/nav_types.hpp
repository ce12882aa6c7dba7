#pragma once
#include <Eigen/Core>
#include <cstdint>

#include "core/geodesy.hpp"
#include "core/memcpy_safe.hpp"
#include "core/time.hpp"

/// What goes into the navigation filter and what comes out. GNSS fixes are core::GnssFix.
namespace kawara::estimation {

/// One inertial sample, body frame forward-right-down. `time` is the END of the interval it covers.
struct ImuSample {
  core::GpsTime time;
  Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Zero();  ///< at rest level: z about -9.8
};

/// Wheels: speed along the vehicle, and its turn rate where left and right wheels are counted.
struct OdometrySample {
  core::GpsTime time;
  double speed_mps = 0.0;  ///< forward positive
  bool has_turn_rate = false;
  double turn_rate_radps = 0.0;  ///< clockwise from above positive, as body z down
};

/// Attitude by the unit's own filter or by a second antenna.
struct AttitudeSample {
  core::GpsTime time;
  bool has_level = false;  ///< roll and pitch mean something
  bool has_heading = false;
  core::Attitude attitude;  ///< yaw is TRUE heading
  /// One standard deviation of the heading [rad] if it is a geodetic measurement of its own (two
  /// antennas), white from sample to sample; 0: a magnetic heading, whose error lasts.
  double heading_sd_rad = 0.0;
};

/// How the solution stands, ordered by trust.
enum class NavState : std::uint8_t {
  kNone = 0,           ///< nothing known yet
  kAligning = 1,       ///< position known, heading not settled among its hypotheses
  kInertial = 2,       ///< no GNSS, no wheels: free inertial
  kDeadReckoning = 3,  ///< no GNSS: inertial with wheels or the vehicle's constraints
  kCode = 4,           ///< code positions
  kFloat = 5,          ///< RTK float
  kFixed = 6,          ///< RTK fixed and believed
};
const char* ToString(NavState state);  ///< "none" ... "fixed"

/// Why the state is not better.
enum class NavReason : std::uint8_t {
  kNominal = 0,
  kNoFixYet,        ///< no position ever came
  kHeadingUnknown,  ///< several headings are still possible
  kNoGnss,          ///< positions stopped coming
  kGnssRefused,     ///< positions come and contradict the prediction: a wrong fix
  kProbation,       ///< fixes are back and must prove themselves first
  kReset,           ///< the filter gave in to fixes that stayed and started anew there
  kImuGap,          ///< inertial samples were missing
  kNotFixed,        ///< the receiver itself is in float or code mode
};
const char* ToString(NavReason reason);

/// Errors of position, velocity and attitude, in this order; north, east, down each. The attitude
/// error is the rotation vector in NED that takes the estimate to the truth.
using NavCovariance = Eigen::Matrix<double, 9, 9>;

/// Where the body is and how it moves at one instant.
struct NavKinematics {
  core::GpsTime time;       ///< on the GNSS time scale: the offset of the IMU's clock is applied
  core::Geodetic position;  ///< of the IMU (or of the point asked for)
  Eigen::Vector3d velocity_ned_mps = Eigen::Vector3d::Zero();
  core::Attitude attitude;
  Eigen::Vector3d rate_frd_radps = Eigen::Vector3d::Zero();  ///< corrected by bias and scale
  NavState state = NavState::kNone;
  NavReason reason = NavReason::kNoFixYet;
  double gnss_age_s = 0.0;  ///< since the last position that was believed

  bool valid() const { return state >= NavState::kInertial; }
};

/// That, and how well it is known.
struct NavSolution : NavKinematics {
  NavCovariance covariance = NavCovariance::Zero();

  Eigen::Vector3d position_sd_ned_m() const;
  Eigen::Vector3d velocity_sd_ned_mps() const;
  Eigen::Vector3d attitude_sd_rad() const;  ///< roll, pitch, yaw
};

/// The same instant at a point of the body `lever_frd_m` away from the IMU, covariance with it.
NavSolution MovedTo(const NavSolution& solution, const Eigen::Vector3d& lever_frd_m);

/// Between two solutions that follow each other: position by cubic Hermite of position and
/// velocity, attitude on SO(3), covariance linear. `t` outside: the nearer end carried on by its
/// velocity and rate, for a sample interval or so.
NavSolution Interpolated(const NavSolution& before, const NavSolution& after, core::GpsTime t);

}  // namespace kawara::estimation

template <>
inline constexpr bool kawara::core::kMemcpySafe<kawara::estimation::ImuSample> = true;
template <>
inline constexpr bool kawara::core::kMemcpySafe<kawara::estimation::NavSolution> = true;
