#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <variant>

#include "core/fixed_text.hpp"
#include "drivers/nmea_sentence.hpp"
#include "drivers/text_fields.hpp"

/// Text replies of Ashtech and Thales receivers, $PASHR,<type>,...
/// Source: Ashtech Z-Family Technical Reference Manual 630203-01 (chapters 2, 4 and 6), Z-12
/// Real-Time Sensor manual (event marker, GGA), Spectra ProFlex 800 and SP90M manuals (codes of
/// POS); checked on a recorded AC12. Example sentences printed in those manuals are no test
/// vectors: more than half fail their own checksum. Pure functions, no allocation, any thread.
namespace kawara::drivers {

/// Position. Course, speed and vertical velocity are as sent: their units depend on the model, see
/// receiver_profile.hpp.
struct AshtechPos {
  int type = -1;  ///< -1 none, 0 autonomous, 1 code differential, 2 float, 3 fixed, ...
  int satellites = -1;
  std::optional<core::Duration> time_utc;
  bool has_position = false;
  double lat_deg = kNotSaid, lon_deg = kNotSaid;
  double height_m =
      kNotSaid;  ///< of the chosen datum; above the ellipsoid unless HGT was set otherwise
  double age_s = kNotSaid;  ///< newer models
  double course_deg = kNotSaid;
  double speed_as_sent = kNotSaid;
  double vertical_as_sent = kNotSaid;  ///< up positive
  double pdop = kNotSaid, hdop = kNotSaid, vdop = kNotSaid, tdop = kNotSaid;
  core::FixedText<8> tail;  ///< firmware version, on newer models the base's id
};

/// Position with its covariance: the only output that has all of it.
struct AshtechCbn {
  std::optional<core::Duration> time_utc;
  core::FixedText<8> site;
  int satellites = -1;
  double pdop = kNotSaid;
  bool has_position = false;
  double lat_deg = kNotSaid, lon_deg = kNotSaid;
  double h_ellipsoidal_m = kNotSaid;
  double lat_sd_m = kNotSaid, lon_sd_m = kNotSaid, height_sd_m = kNotSaid;
  /// Cross terms in the order lat-lon, lat-height, lon-height; taken as covariances [m^2], which is
  /// how the binary form defines them.
  std::array<double, 3> cross_m2{kNotSaid, kNotSaid, kNotSaid};
  /// Digits A..F: 0 none 1 2D 2 3D; 0 autonomous 1 RTCM 2 CPD; fixed; projected in time; moving
  /// base; fast CPD.
  std::array<std::uint8_t, 6> flags{};
  double east_mps = kNotSaid, north_mps = kNotSaid, up_mps = kNotSaid;
  double east_sd_mps = kNotSaid, north_sd_mps = kNotSaid, up_sd_mps = kNotSaid;
};

/// TTT: the instant of an event pulse (shutter). PTT: of the PPS pulse. GPS time, not UTC.
struct AshtechTimeTag {
  bool is_event = false;          ///< TTT
  core::Duration time_of_week{};  ///< since Sunday 00:00 GPS
};

struct AshtechLatency {
  double latency_s = 0.0;  ///< time tag to output
};

/// RRE (also sent as $GPRRE): residuals and the receiver's estimate of its error.
struct AshtechResiduals {
  std::uint8_t count = 0;
  struct Satellite {
    int id = -1;
    double residual_m = kNotSaid;
  };
  std::array<Satellite, 32> satellites{};
  double horizontal_rms_m = kNotSaid, vertical_rms_m = kNotSaid;
};

/// SAT: azimuth comes BEFORE elevation, opposite to GSV.
struct AshtechSatellites {
  std::uint8_t count = 0;
  struct Satellite {
    int id = -1;
    int azimuth_deg = -1, elevation_deg = -1, snr_dbhz = -1;
    bool used = false;
  };
  std::array<Satellite, 32> satellites{};
};

struct AshtechAck {
  bool accepted = false;  ///< ACK, else NAK
};
/// RID: who the receiver is.
struct AshtechIdentity {
  core::FixedText<80> text;         ///< all fields as sent
  core::FixedText<8> model;         ///< "UZ"
  core::FixedText<8> nav_firmware;  ///< "ZC00"
};
/// PRT: the port the question came through, and its speed.
struct AshtechPort {
  char port = '\0';
  int baud_code = -1;
  int baud_bps = 0;  ///< 0: code not known
};
struct AshtechPps {
  double period_s = 0.0;
  double offset_ms = 0.0;
  char edge = '\0';  ///< R or F
};
struct AshtechEventEdge {
  char edge = '\0';  ///< PHE: R or F
};
/// XMG: what the receiver says in words.
struct AshtechText {
  int code = -1;
  core::FixedText<80> text;
};
/// Right checksum, a type not in this file.
struct AshtechOther {};
/// Right checksum, a type of this file, contents it cannot have.
struct AshtechInvalid {};

using AshtechBody =
    std::variant<AshtechOther, AshtechInvalid, AshtechPos, AshtechCbn, AshtechTimeTag,
                 AshtechLatency, AshtechResiduals, AshtechSatellites, AshtechAck, AshtechIdentity,
                 AshtechPort, AshtechPps, AshtechEventEdge, AshtechText>;

/// "POS" of "PASHR,POS,..."; empty for other sentences.
std::string_view AshtechType(const NmeaSentence& sentence) noexcept;
/// Of a sentence with the address PASHR (or GPRRE).
AshtechBody ParseAshtech(const NmeaSentence& sentence) noexcept;

/// Bits per second of the maker's speed codes 0..9 (300 ... 115200); 0 for others. And back: -1 if
/// there is none.
int AshtechBaud(int code) noexcept;
int AshtechBaudCode(int baud_bps) noexcept;

}  // namespace kawara::drivers
