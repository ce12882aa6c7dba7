#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "core/geodesy.hpp"
#include "core/memcpy_safe.hpp"
#include "core/time.hpp"

/// The plain measurements that drivers hand out and everything else takes in. Trivially copyable
/// apart from Eigen members, no heap: safe to push through a real-time ring.
namespace kawara::core {

/// Kind of GNSS solution, ordered by trust. Encodings of receivers are mapped to this in drivers/.
enum class RtkState : std::uint8_t {
  kNone = 0,
  kAutonomous = 1,
  kCodeDifferential = 2,
  kFloat = 3,
  kFixed = 4,
  kDeadReckoning = 5,  ///< estimated by the receiver, no satellites
};
const char* ToString(
    RtkState s);  ///< "none", "autonomous", "dgps", "float", "fixed", "dead-reckoning"

/// Why a picture was taken; the numbers are phase1_t.reason.
enum class PictureReason : std::uint8_t {
  kEveryEpochs = 0,
  kDistance = 1,
  kCommand = 2,
  kFreeRunning = 3,  ///< there was no GPS time to schedule by
};
const char* ToString(PictureReason r);  ///< "every_n", "distance", "command", "free_running"

/// One epoch of a GNSS receiver, merged from all sentences of that epoch.
struct GnssFix {
  GpsTime time;      ///< epoch of validity
  MonoTime arrival;  ///< first byte of the epoch's first sentence
  RtkState rtk = RtkState::kNone;
  std::uint8_t native_quality = 0;  ///< the receiver's own code, as sent (GGA field 6 or POS type)
  bool has_position = false;
  Geodetic antenna;  ///< position of the ANTENNA
  /// Covariance of the position, east, north, up [m^2]. From CBN or GST; else from a table by
  /// RtkState.
  Eigen::Matrix3d position_cov_enu_m2 = Eigen::Matrix3d::Zero();
  bool covariance_from_receiver = false;
  bool has_velocity = false;
  Eigen::Vector3d velocity_enu_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_sd_enu_mps = Eigen::Vector3d::Zero();
  double geoid_separation_m = 0.0;  ///< NaN if the receiver did not say
  double hdop = 0.0;                ///< NaN if the receiver did not say
  double correction_age_s = 0.0;    ///< NaN if the receiver did not say
  double latency_s = 0.0;  ///< time tag to output as the receiver states it (LTN), NaN unknown
  std::uint16_t satellites = 0;
  std::uint16_t base_station = 0;
  bool has_heading = false;  ///< true heading from HDT/THS/ATT
  double heading_rad = 0.0;
};

/// One sample of the attitude and heading reference system, sensor frame (x forward, y right, z
/// down).
struct AhrsSample {
  MonoTime arrival;  ///< first byte of the packet on the wire
  MonoTime sampled;  ///< sensor counter unwrapped onto the monotonic clock; what estimation uses
  bool has_attitude = false;
  Attitude attitude;  ///< the unit's own coarse filter, NED, heading MAGNETIC
  Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Zero();  ///< at rest level: z about -9.8
  Eigen::Vector3d magnetic_gauss = Eigen::Vector3d::Zero();
  double temperature_degc = 0.0;
  std::uint16_t counter = 0;  ///< raw 16-bit down-counter, 0.79 us a tick
};

/// Where the reference point of the body is and how it stands, at one instant.
struct Pose {
  GpsTime time;
  MonoTime mono;  ///< the same instant on this machine's clock
  Geodetic position;
  Attitude attitude;  ///< yaw is TRUE heading
  Eigen::Vector3d velocity_enu_mps = Eigen::Vector3d::Zero();
  Eigen::Matrix3d position_cov_enu_m2 = Eigen::Matrix3d::Zero();
  Eigen::Vector3d attitude_sd_rad = Eigen::Vector3d::Zero();  ///< roll, pitch, yaw
  RtkState rtk = RtkState::kNone;
  double gnss_age_s = 0.0;  ///< time since the last fix used
  bool valid = false;
};

template <>
inline constexpr bool kMemcpySafe<GnssFix> = true;
template <>
inline constexpr bool kMemcpySafe<AhrsSample> = true;
template <>
inline constexpr bool kMemcpySafe<Pose> = true;

}  // namespace kawara::core
