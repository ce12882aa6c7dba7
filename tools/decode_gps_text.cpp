#include <array>
#include <cstdio>

#include "tools/decode_gps.hpp"

namespace kawara::tools {
namespace {

using namespace drivers;  // the message types, all of them
using core::ToString;

constexpr int kAngleDecimals = 10;  // 0.01 mm
constexpr int kMetreDecimals = 4;
constexpr int kSpeedDecimals = 4;

/// -1 stands for an empty field.
void Count(JsonLines& out, std::string_view key, int value) {
  if (value == kNoInteger) {
    out.Null(key);
  } else {
    out.Integer(key, value);
  }
}

void Letter(JsonLines& out, std::string_view key, char letter) {
  if (letter == '\0') {
    out.Null(key);
  } else {
    out.Text(key, {&letter, 1});
  }
}

void Position(JsonLines& out, double lat_deg, double lon_deg) {
  out.Number("lat_deg", lat_deg, kAngleDecimals);
  out.Number("lon_deg", lon_deg, kAngleDecimals);
}

void Date(JsonLines& out, bool has_date, int year, int month, int day) {
  if (has_date) {
    WriteDate(out, "date", year, month, day);
  } else {
    out.Null("date");
  }
}

void Sigmas(JsonLines& out, double lat_m, double lon_m, double alt_m) {
  out.Number("lat_sd_m", lat_m, kMetreDecimals);
  out.Number("lon_sd_m", lon_m, kMetreDecimals);
  out.Number("alt_sd_m", alt_m, kMetreDecimals);
}

/// One overload for each kind of contents; WriteText picks it.
struct Writer {
  JsonLines& out;
  ReceiverProfile profile;

  void operator()(const NmeaOther&) const {}
  void operator()(const NmeaInvalid&) const {}
  void operator()(const AshtechOther&) const {}
  void operator()(const AshtechInvalid&) const {}

  void operator()(const NmeaGga& m) const {
    WriteTimeOfDay(out, "time_utc", m.time_utc);
    Position(out, m.lat_deg, m.lon_deg);
    out.Unsigned("quality", m.quality);
    out.Text("rtk_state", ToString(RtkStateOfGga(m.quality, profile)));
    Count(out, "satellites", m.satellites);
    out.Number("hdop", m.hdop, 3);
    out.Number("altitude_m", m.altitude_m, kMetreDecimals);
    out.Number("geoid_separation_m", m.geoid_separation_m, kMetreDecimals);
    out.Number("height_ellipsoidal_m", EllipsoidalHeight(m), kMetreDecimals);
    const AgeAndLatency age = AgeOfGga(m, profile);
    out.Number("age_s", age.age_s, 3);
    if (profile == ReceiverProfile::kAshtechLegacy) out.Number("latency_s", age.latency_s, 3);
    Count(out, "station", m.station);
  }
  void operator()(const NmeaRmc& m) const {
    Date(out, m.has_date, m.year, m.month, m.day);
    WriteTimeOfDay(out, "time_utc", m.time_utc);
    out.Boolean("valid", m.valid);
    Position(out, m.lat_deg, m.lon_deg);
    out.Number("speed_mps", m.speed_mps, kSpeedDecimals);
    out.Number("course_deg", m.course_deg, 4);
    out.Number("magnetic_variation_deg", m.magnetic_variation_deg, 4);
    Letter(out, "mode", m.mode);
    Letter(out, "navigational_status", m.nav_status);
  }
  void operator()(const NmeaVtg& m) const {
    out.Number("course_true_deg", m.course_true_deg, 4);
    out.Number("course_magnetic_deg", m.course_magnetic_deg, 4);
    out.Number("speed_mps", m.speed_mps, kSpeedDecimals);
    Letter(out, "mode", m.mode);
  }
  void operator()(const NmeaGst& m) const {
    WriteTimeOfDay(out, "time_utc", m.time_utc);
    out.Number("rms_m", m.rms_m, kMetreDecimals);
    out.Number("semi_major_m", m.semi_major_m, kMetreDecimals);
    out.Number("semi_minor_m", m.semi_minor_m, kMetreDecimals);
    out.Number("orientation_deg", m.orientation_deg, 4);
    Sigmas(out, m.lat_sd_m, m.lon_sd_m, m.alt_sd_m);
  }
  void operator()(const NmeaGsa& m) const {
    Letter(out, "selection", m.selection);
    out.Unsigned("fix", m.fix);
    out.OpenArray("satellites");
    for (std::size_t i = 0; i < m.count; ++i) out.Unsigned("", m.satellites[i]);
    out.CloseArray();
    out.Number("pdop", m.pdop, 3);
    out.Number("hdop", m.hdop, 3);
    out.Number("vdop", m.vdop, 3);
    if (m.system != kNoInteger) out.Integer("system", m.system);
  }
  void operator()(const NmeaGsv& m) const {
    out.Unsigned("sentences", m.total);
    out.Unsigned("index", m.index);
    Count(out, "in_view", m.in_view);
    out.OpenArray("satellites");
    for (std::size_t i = 0; i < m.count; ++i) {
      const NmeaGsv::Satellite& s = m.satellites[i];
      out.OpenObject("");
      Count(out, "id", s.id);
      if (s.elevation_deg == kNoElevation) {
        out.Null("elevation_deg");
      } else {
        out.Integer("elevation_deg", s.elevation_deg);
      }
      Count(out, "azimuth_deg", s.azimuth_deg);
      Count(out, "snr_dbhz", s.snr_dbhz);
      out.CloseObject();
    }
    out.CloseArray();
    if (m.signal != kNoInteger) out.Integer("signal", m.signal);
  }
  void operator()(const NmeaZda& m) const {
    Date(out, m.has_date, m.year, m.month, m.day);
    WriteTimeOfDay(out, "time_utc", m.time_utc);
    out.Integer("zone_hours", m.zone_hours);
    out.Integer("zone_minutes", m.zone_minutes);
  }
  void operator()(const NmeaHeading& m) const {
    out.Number("true_heading_deg", m.true_heading_deg, 4);
    Letter(out, "mode", m.mode);
  }
  void operator()(const NmeaGbs& m) const {
    WriteTimeOfDay(out, "time_utc", m.time_utc);
    Sigmas(out, m.lat_sd_m, m.lon_sd_m, m.alt_sd_m);
    Count(out, "failed_satellite", m.failed_satellite);
    out.Number("missed_probability", m.missed_probability, 6);
    out.Number("bias_m", m.bias_m, kMetreDecimals);
    out.Number("bias_sd_m", m.bias_sd_m, kMetreDecimals);
    if (m.system != kNoInteger) out.Integer("system", m.system);
    if (m.signal != kNoInteger) out.Integer("signal", m.signal);
  }

  void operator()(const AshtechPos& m) const {
    WriteTimeOfDay(out, "time_utc", m.time_utc);
    Position(out, m.lat_deg, m.lon_deg);
    Count(out, "position_type", m.type);
    out.Text("rtk_state", ToString(RtkStateOfPos(m.type)));
    Count(out, "satellites", m.satellites);
    out.Number("height_m", m.height_m, kMetreDecimals);
    out.Number("age_s", m.age_s, 3);
    out.Number("course_deg", m.course_deg, 4);
    const PosVelocity velocity = VelocityOfPos(m, profile);
    out.Number("speed_mps", velocity.speed_mps, kSpeedDecimals);
    out.Number("vertical_velocity_mps", velocity.up_mps, kSpeedDecimals);
    out.Number("pdop", m.pdop, 3);
    out.Number("hdop", m.hdop, 3);
    out.Number("vdop", m.vdop, 3);
    out.Number("tdop", m.tdop, 3);
    out.Text("firmware_or_base", m.tail.view());
  }
  void operator()(const AshtechCbn& m) const {
    WriteTimeOfDay(out, "time_utc", m.time_utc);
    out.Text("site", m.site.view());
    Count(out, "satellites", m.satellites);
    out.Number("pdop", m.pdop, 3);
    Position(out, m.lat_deg, m.lon_deg);
    out.Number("height_ellipsoidal_m", m.h_ellipsoidal_m, kMetreDecimals);
    Sigmas(out, m.lat_sd_m, m.lon_sd_m, m.height_sd_m);
    out.OpenArray("cross_m2");
    for (const double cross : m.cross_m2) out.Number("", cross, 6);
    out.CloseArray();
    out.OpenArray("flags");
    for (const std::uint8_t flag : m.flags) out.Unsigned("", flag);
    out.CloseArray();
    out.Text("rtk_state", ToString(RtkStateOfCbn(m)));
    out.Number("velocity_east_mps", m.east_mps, kSpeedDecimals);
    out.Number("velocity_north_mps", m.north_mps, kSpeedDecimals);
    out.Number("velocity_up_mps", m.up_mps, kSpeedDecimals);
    out.Number("velocity_east_sd_mps", m.east_sd_mps, kSpeedDecimals);
    out.Number("velocity_north_sd_mps", m.north_sd_mps, kSpeedDecimals);
    out.Number("velocity_up_sd_mps", m.up_sd_mps, kSpeedDecimals);
  }
  void operator()(const AshtechTimeTag& m) const {
    out.Number("gps_time_of_week_s", core::ToSeconds(m.time_of_week), 7);
  }
  void operator()(const AshtechLatency& m) const { out.Number("latency_s", m.latency_s, 6); }
  void operator()(const AshtechResiduals& m) const {
    out.OpenArray("satellites");
    for (std::size_t i = 0; i < m.count; ++i) {
      out.OpenObject("");
      Count(out, "id", m.satellites[i].id);
      out.Number("residual_m", m.satellites[i].residual_m, kMetreDecimals);
      out.CloseObject();
    }
    out.CloseArray();
    out.Number("horizontal_rms_m", m.horizontal_rms_m, kMetreDecimals);
    out.Number("vertical_rms_m", m.vertical_rms_m, kMetreDecimals);
  }
  void operator()(const AshtechSatellites& m) const {
    out.OpenArray("satellites");
    for (std::size_t i = 0; i < m.count; ++i) {
      const AshtechSatellites::Satellite& s = m.satellites[i];
      out.OpenObject("");
      Count(out, "id", s.id);
      Count(out, "azimuth_deg", s.azimuth_deg);
      Count(out, "elevation_deg", s.elevation_deg);
      Count(out, "snr_dbhz", s.snr_dbhz);
      out.Boolean("used", s.used);
      out.CloseObject();
    }
    out.CloseArray();
  }
  void operator()(const AshtechAck& m) const { out.Boolean("accepted", m.accepted); }
  void operator()(const AshtechIdentity& m) const {
    out.Text("identity", m.text.view());
    out.Text("model", m.model.view());
    out.Text("nav_firmware", m.nav_firmware.view());
  }
  void operator()(const AshtechPort& m) const {
    Letter(out, "port", m.port);
    Count(out, "baud_code", m.baud_code);
    out.Integer("baud_bps", m.baud_bps);
  }
  void operator()(const AshtechPps& m) const {
    out.Number("period_s", m.period_s, 4);
    out.Number("offset_s", m.offset_ms * 1e-3, 7);
    Letter(out, "edge", m.edge);
  }
  void operator()(const AshtechEventEdge& m) const { Letter(out, "edge", m.edge); }
  void operator()(const AshtechText& m) const {
    Count(out, "code", m.code);
    out.Text("text", m.text.view());
  }
};

}  // namespace

void WriteText(JsonLines& out, const NmeaBody& body, ReceiverProfile profile) {
  std::visit(Writer{out, profile}, body);
}

void WriteText(JsonLines& out, const AshtechBody& body, ReceiverProfile profile) {
  std::visit(Writer{out, profile}, body);
}

void WriteTimeOfDay(JsonLines& out, std::string_view key,
                    const std::optional<core::Duration>& time) {
  if (!time) return out.Null(key);
  const std::int64_t ns = time->count();
  // The leap second is 23:59:60, not 24:00:00.
  const std::int64_t minute = std::min<std::int64_t>(ns / 60'000'000'000, 24 * 60 - 1);
  const std::int64_t rest = ns - minute * 60'000'000'000;
  std::array<char, 40> text{};
  const int n =
      std::snprintf(text.data(), text.size(), "%02d:%02d:%02d.%09d", static_cast<int>(minute / 60),
                    static_cast<int>(minute % 60), static_cast<int>(rest / 1'000'000'000),
                    static_cast<int>(rest % 1'000'000'000));
  std::string_view view(text.data(), static_cast<std::size_t>(n));
  while (view.back() == '0') view.remove_suffix(1);
  if (view.back() == '.') view.remove_suffix(1);
  out.Text(key, view);
}

void WriteDate(JsonLines& out, std::string_view key, int year, int month, int day) {
  std::array<char, 40> text{};
  const int n = std::snprintf(text.data(), text.size(), "%04d-%02d-%02d", year, month, day);
  out.Text(key, {text.data(), static_cast<std::size_t>(n)});
}

}  // namespace kawara::tools
