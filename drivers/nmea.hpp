#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <variant>

#include "drivers/nmea_sentence.hpp"
#include "drivers/text_fields.hpp"

/// NMEA 0183 versions 2.3 to 4.11: the sentences a surveying receiver sends. Any talker.
/// A field the receiver left empty is NaN, -1, '\0' or no value. Each parser checks the number of
/// fields, their kind and their range: the checksum lets 1 in 256 damaged sentences through, and
/// those must not become positions. Source: NMEA 0183 as gpsd documents it (www/NMEA.adoc), checked
/// on recorded sentences of u-blox, Trimble, Ashtech and RTKLIB. Pure functions, no allocation, any
/// thread.
namespace kawara::drivers {

/// Number of satellites, station and the like when the field is empty.
constexpr int kNoInteger = -1;
/// Elevations may be negative.
constexpr int kNoElevation = -128;

struct NmeaGga {
  std::optional<core::Duration> time_utc;  ///< of day
  bool has_position = false;
  double lat_deg = kNotSaid;
  double lon_deg = kNotSaid;
  std::uint8_t quality =
      0;  ///< as sent; what 2 and 3 mean depends on the maker: receiver_profile.hpp
  int satellites = kNoInteger;
  double hdop = kNotSaid;
  double altitude_m = kNotSaid;          ///< above the geoid, unless the separation is empty
  double geoid_separation_m = kNotSaid;  ///< geoid above ellipsoid
  double age_s = kNotSaid;               ///< of corrections, as sent
  int station = kNoInteger;
};

struct NmeaRmc {
  std::optional<core::Duration> time_utc;
  bool valid = false;  ///< status A; the navigation status of 4.1 is another matter
  bool has_position = false;
  double lat_deg = kNotSaid;
  double lon_deg = kNotSaid;
  double speed_mps = kNotSaid;
  double course_deg = kNotSaid;
  bool has_date = false;
  int year = 0, month = 0, day = 0;
  double magnetic_variation_deg = kNotSaid;  ///< east positive
  char mode = '\0';                          ///< 2.3: A D E F M N P R S
  char nav_status = '\0';  ///< 4.1: S C U V; V (not giving a status) is what u-blox always sends
};

struct NmeaVtg {
  double course_true_deg = kNotSaid;
  double course_magnetic_deg = kNotSaid;
  double speed_mps = kNotSaid;
  char mode = '\0';
};

/// The only standard statement of accuracy; one sigma.
struct NmeaGst {
  std::optional<core::Duration> time_utc;
  double rms_m = kNotSaid;
  double semi_major_m = kNotSaid, semi_minor_m = kNotSaid;
  double orientation_deg = kNotSaid;  ///< of the major axis, from true north
  double lat_sd_m = kNotSaid, lon_sd_m = kNotSaid, alt_sd_m = kNotSaid;
};

struct NmeaGsa {
  char selection = '\0';   ///< M manual, A automatic
  std::uint8_t fix = 0;    ///< 1 none, 2 two-dimensional, 3 three-dimensional
  std::uint8_t count = 0;  ///< satellites listed
  std::array<std::uint16_t, 12> satellites{};
  double pdop = kNotSaid, hdop = kNotSaid, vdop = kNotSaid;
  int system = kNoInteger;  ///< 4.11
};

struct NmeaGsv {
  std::uint8_t total = 0, index = 0;  ///< sentences of this set, which one (from 1)
  int in_view = kNoInteger;
  std::uint8_t count = 0;
  struct Satellite {
    int id = kNoInteger;
    int elevation_deg = kNoElevation;
    int azimuth_deg = kNoInteger;
    int snr_dbhz = kNoInteger;
  };
  std::array<Satellite, 4> satellites{};
  int signal = kNoInteger;  ///< 4.10
};

/// Some receivers send it a second ahead of the position of the same burst: a date, not an epoch.
struct NmeaZda {
  std::optional<core::Duration> time_utc;
  bool has_date = false;
  int year = 0, month = 0, day = 0;
  int zone_hours = 0, zone_minutes = 0;
};

/// HDT, and THS whose mode says whether the heading may be used (A autonomous ... V not valid).
struct NmeaHeading {
  double true_heading_deg = kNotSaid;
  char mode = '\0';  ///< of THS; '\0' for HDT
};

struct NmeaGbs {
  std::optional<core::Duration> time_utc;
  double lat_sd_m = kNotSaid, lon_sd_m = kNotSaid, alt_sd_m = kNotSaid;
  int failed_satellite = kNoInteger;
  double missed_probability = kNotSaid, bias_m = kNotSaid, bias_sd_m = kNotSaid;
  int system = kNoInteger, signal = kNoInteger;  ///< 4.11
};

/// Right checksum, a type not in this file.
struct NmeaOther {};
/// Right checksum, a type of this file, contents it cannot have.
struct NmeaInvalid {};

using NmeaBody = std::variant<NmeaOther, NmeaInvalid, NmeaGga, NmeaRmc, NmeaVtg, NmeaGst, NmeaGsa,
                              NmeaGsv, NmeaZda, NmeaHeading, NmeaGbs>;
NmeaBody ParseNmea(const NmeaSentence& sentence) noexcept;

/// The single parsers; no value: contents the sentence cannot have. They do not look at the
/// address.
std::optional<NmeaGga> ParseGga(const NmeaSentence& sentence) noexcept;
std::optional<NmeaRmc> ParseRmc(const NmeaSentence& sentence) noexcept;
std::optional<NmeaVtg> ParseVtg(const NmeaSentence& sentence) noexcept;
std::optional<NmeaGst> ParseGst(const NmeaSentence& sentence) noexcept;
std::optional<NmeaGsa> ParseGsa(const NmeaSentence& sentence) noexcept;
std::optional<NmeaGsv> ParseGsv(const NmeaSentence& sentence) noexcept;
std::optional<NmeaZda> ParseZda(const NmeaSentence& sentence) noexcept;
std::optional<NmeaHeading> ParseHdt(const NmeaSentence& sentence) noexcept;
std::optional<NmeaHeading> ParseThs(const NmeaSentence& sentence) noexcept;
std::optional<NmeaGbs> ParseGbs(const NmeaSentence& sentence) noexcept;

}  // namespace kawara::drivers
