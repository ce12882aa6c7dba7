#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <variant>

#include "core/time.hpp"
#include "drivers/rtcm3_frame.hpp"

/// What the robot needs to know about each RTCM 3 message: who sent it, when it was measured, how
/// much is in it, and where the base stands. Headers and counts only: pseudoranges and phases are
/// the receiver's business. RTKLIB decodes those well and is our yardstick in tests, but its
/// decoder allocates megabytes of ephemeris tables, takes the week from the wall clock and prints
/// traces, so it has no place on the real-time path. Source: RTCM 10403.1-.3 message tables;
/// checked against RTKLIB and recorded streams.
namespace kawara::drivers {

enum class GnssSystem : std::uint8_t { kGps, kGlonass, kGalileo, kSbas, kQzss, kBeidou, kNavic };
const char* ToString(GnssSystem s);  ///< "GPS", "GLONASS", ...

/// 1001-1004, 1009-1012 and MSM1-7 of every constellation.
struct Rtcm3Observations {
  GnssSystem system = GnssSystem::kGps;
  std::uint8_t msm = 0;  ///< 1..7, or 0 for the older messages
  /// Time of measurement as sent: GLONASS: time of day of UTC + 3 h (24 h and more in a leap
  /// second); BeiDou: time of week of GPS - 14 s; all others: GPS time of week. EpochOf() makes a
  /// GpsTime of it.
  core::Duration time_sent{};
  std::int8_t glonass_day_of_week = -1;  ///< 0 Sunday .. 6; -1 not sent or unknown
  bool more_follow = false;  ///< other messages of the same epoch and station come after this one
  std::uint8_t satellites = 0;
  std::uint8_t signals = 0;        ///< kinds of signals (1 or 2 bands in the older messages)
  std::uint16_t observations = 0;  ///< satellite-signal pairs present (MSM cells; L1 plus valid L2)
  std::uint64_t satellite_mask = 0;  ///< bit i: satellite with number i + 1 as sent
};

/// 1005, 1006: the antenna reference point.
struct Rtcm3Station {
  Eigen::Vector3d ecef_m = Eigen::Vector3d::Zero();  ///< resolution 0.1 mm
  bool has_antenna_height = false;                   ///< 1006
  double antenna_height_m = 0.0;
  bool gps = false, glonass = false, galileo = false;
  bool virtual_station = false;  ///< not a physical reference station
  std::uint8_t itrf_year = 0;
};

/// 1007, 1008, 1033. Views into the payload.
struct Rtcm3Descriptor {
  std::string_view antenna;
  std::uint8_t antenna_setup = 0;
  std::string_view antenna_serial;
  std::string_view receiver;
  std::string_view receiver_firmware;
  std::string_view receiver_serial;
};

/// 1230: GLONASS code-phase biases [m] of L1 C/A, L1 P, L2 C/A, L2 P; NaN where not sent.
struct Rtcm3GlonassBiases {
  bool aligned = false;
  std::array<double, 4> bias_m{};
};

/// 1019 GPS, 1020 GLONASS, 1042 BeiDou, 1044 QZSS, 1045/1046 Galileo: of whom, not the orbit
/// itself.
struct Rtcm3Ephemeris {
  GnssSystem system = GnssSystem::kGps;
  std::uint8_t satellite = 0;  ///< within its system, from 1
};

/// 1013 system parameters.
struct Rtcm3SystemParameters {
  std::uint16_t modified_julian_day = 0;  ///< as sent (16 bits)
  std::uint32_t second_of_day = 0;
  std::uint8_t leap_seconds = 0;  ///< GPS - UTC; 255 = not sent
  std::uint8_t announced = 0;     ///< how many message types follow
  struct Announcement {
    std::uint16_t type = 0;
    bool synchronous = false;
    double interval_s = 0.0;
  };
  std::array<Announcement, 31> announcements{};
};

/// 1029: text for people, UTF-8, a view into the payload.
struct Rtcm3Text {
  std::uint16_t modified_julian_day = 0;
  std::uint32_t second_of_day = 0;
  std::uint8_t characters = 0;
  std::string_view utf8;
};

struct Rtcm3Message {
  std::uint16_t type = 0;    ///< 0 for an empty frame
  std::uint16_t length = 0;  ///< payload bytes
  bool has_station = false;
  std::uint16_t station = 0;
  bool malformed = false;  ///< a type we know, but shorter than it claims; `body` is then empty
  std::variant<std::monostate, Rtcm3Observations, Rtcm3Station, Rtcm3Descriptor, Rtcm3GlonassBiases,
               Rtcm3Ephemeris, Rtcm3SystemParameters, Rtcm3Text>
      body;  ///< empty for types not listed above: pass them on by length
};

/// Decodes a payload (see Rtcm3Payload). Never fails: what is not understood has an empty body.
/// Views point into `payload`. No allocation, real-time safe, any thread.
Rtcm3Message DecodeRtcm3(std::span<const std::uint8_t> payload) noexcept;

/// The epoch of observations on the GPS scale, nearest to `reference` (within half a week, or half
/// a day for GLONASS). Not within a GLONASS leap second (time of day of 24 h or more).
std::optional<core::GpsTime> EpochOf(const Rtcm3Observations& observations, core::GpsTime reference,
                                     const core::LeapSeconds& leaps = {});

}  // namespace kawara::drivers
