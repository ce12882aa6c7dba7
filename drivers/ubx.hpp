#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>

#include "drivers/text_fields.hpp"

/// u-blox binary frames: what a receiver of theirs sends between or instead of NMEA. Framing of all
/// messages, contents of the two that make a fix. Source: u-blox M8/F9 interface descriptions;
/// checked on a recorded ZED-F9P against gpsd's decode of the same bytes.
namespace kawara::drivers {

/// Longest frame accepted (raw measurements of 90 signals have 2.9 KB).
constexpr std::size_t kUbxMaxBytes = 3072;

/// NAV-PVT (01 07): a whole epoch.
struct UbxNavPvt {
  core::Duration time_of_week{};  ///< GPS
  bool has_date = false;          ///< date and time are resolved and valid
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0;
  std::int32_t nanosecond = 0;  ///< may be negative
  std::uint8_t fix_type = 0;    ///< 0 none, 1 dead reckoning, 2 2D, 3 3D, 4 combined, 5 time only
  bool fix_ok = false;
  bool differential = false;
  std::uint8_t carrier = 0;  ///< 0 none, 1 float, 2 fixed
  std::uint8_t satellites = 0;
  double lat_deg = 0.0, lon_deg = 0.0;
  double h_ellipsoidal_m = 0.0, altitude_msl_m = 0.0;
  double horizontal_sd_m = 0.0, vertical_sd_m = 0.0;
  double north_mps = 0.0, east_mps = 0.0, down_mps = 0.0;
  double speed_sd_mps = 0.0;
  double ground_speed_mps = 0.0, course_deg = 0.0;
  double pdop = 0.0;
};
/// NAV-TIMEGPS (01 20).
struct UbxNavTimeGps {
  core::Duration time_of_week{};
  int week = 0;
  int gps_minus_utc_s = 0;
  bool week_valid = false;
  bool leap_seconds_valid = false;
};
struct UbxOther {};

struct UbxMessage {
  std::uint8_t message_class = 0;
  std::uint8_t id = 0;
  std::variant<UbxOther, UbxNavPvt, UbxNavTimeGps> body;
};

enum class UbxMatch : std::uint8_t { kNoMatch, kNeedMore, kFrame, kBadChecksum };
struct UbxProbeResult {
  UbxMatch match = UbxMatch::kNoMatch;
  std::size_t length = 0;
};
/// B5 62 | class | id | length, little-endian | payload | two sums (8-bit Fletcher). Pure,
/// real-time safe.
UbxProbeResult UbxProbe(std::span<const std::uint8_t> head) noexcept;
/// Of a frame that UbxProbe called kFrame.
UbxMessage DecodeUbx(std::span<const std::uint8_t> frame) noexcept;

}  // namespace kawara::drivers
