#include "drivers/nmea.hpp"

#include <cmath>

#include "drivers/receiver_profile.hpp"

namespace kawara::drivers {
namespace {

// Wider than anything a working receiver prints, narrower than most of what a damaged digit makes.
constexpr double kMaxDop = 1e5;  // "9999.0" stands for unknown
constexpr double kMaxSigmaM = 1e7;
constexpr double kMinAltitudeM = -2000.0;
constexpr double kMaxAltitudeM = 100'000.0;
constexpr double kMaxSeparationM = 200.0;  // EGM: -107 .. +86
constexpr double kMaxSpeedKnots = 20'000.0;
constexpr double kMpsPerKmh = 1.0 / 3.6;
constexpr std::string_view kModes = "ACDEFMNPRSU";  // positioning mode indicators of RMC, VTG, THS

constexpr std::uint32_t Code(std::string_view type) {
  std::uint32_t code = 0;
  for (const char c : type) code = code << 8 | static_cast<std::uint8_t>(c);
  return code;
}

FieldReader Reader(const NmeaSentence& s) { return FieldReader(s.fields, s.has_fields); }

std::optional<core::Duration> ReadTime(FieldReader& f) {
  core::Duration time{};
  if (!f.TimeOfDay(time)) return std::nullopt;
  return time;
}

bool ValidDate(int year, int month, int day) {
  return core::IsValid({.year = year, .month = month, .day = day});
}

template <class T>
std::optional<T> Checked(const FieldReader& f, const T& value) {
  if (!f.ok()) return std::nullopt;
  return value;
}

/// Station ids are numbers by the standard, names in some receivers; a name is not an error.
int ReadStation(FieldReader& f) {
  const std::string_view text = f.Text();
  Decimal number;
  if (text.empty()) return kNoInteger;
  if (ParseDecimal(text, number) && number.decimals == 0 && number.mantissa >= 0 &&
      number.mantissa <= 65'535) {
    return static_cast<int>(number.mantissa);
  }
  if (text.size() > 8) f.Fail();
  return kNoInteger;
}

/// The finer of knots and km/h. Where both are given they must agree within their rounding: that
/// tells a damaged digit.
double ReadSpeed(FieldReader& f, bool with_units) {
  const std::string_view knots_text = f.Text();
  if (with_units) f.Letter("N");
  const std::string_view kmh_text = f.Text();
  if (with_units) f.Letter("K");
  Decimal knots;
  Decimal kmh;
  const bool has_knots = !knots_text.empty();
  const bool has_kmh = !kmh_text.empty();
  if ((has_knots && !ParseDecimal(knots_text, knots)) || (has_kmh && !ParseDecimal(kmh_text, kmh)))
    f.Fail();
  if (!f.ok()) return kNotSaid;
  const double from_knots = knots.value() * kMpsPerKnot;
  const double from_kmh = kmh.value() * kMpsPerKmh;
  const double step_knots = knots.resolution() * kMpsPerKnot;
  const double step_kmh = kmh.resolution() * kMpsPerKmh;
  if ((has_knots && (from_knots < 0.0 || knots.value() > kMaxSpeedKnots)) ||
      (has_kmh && from_kmh < 0.0)) {
    f.Fail();
  }
  if (has_knots && has_kmh &&
      std::abs(from_knots - from_kmh) > step_knots + step_kmh + 0.01 * from_kmh) {
    f.Fail();
  }
  if (has_knots && (!has_kmh || step_knots <= step_kmh)) return from_knots;
  return has_kmh ? from_kmh : kNotSaid;
}

template <class T>
NmeaBody Body(const std::optional<T>& parsed) {
  if (parsed) return *parsed;
  return NmeaInvalid{};
}

}  // namespace

std::optional<NmeaGga> ParseGga(const NmeaSentence& sentence) noexcept {
  FieldReader f = Reader(sentence);
  if (f.count() != 14) return std::nullopt;
  NmeaGga m;
  m.time_utc = ReadTime(f);
  m.has_position = f.LatLon(m.lat_deg, m.lon_deg);
  m.quality = static_cast<std::uint8_t>(f.Integer(0, 9, 0));
  m.satellites = static_cast<int>(f.Integer(0, 255, kNoInteger));
  m.hdop = f.Number(0.0, kMaxDop);
  m.altitude_m = f.Number(kMinAltitudeM, kMaxAltitudeM);
  f.Letter("M");
  m.geoid_separation_m = f.Number(-kMaxSeparationM, kMaxSeparationM);
  f.Letter("M");
  m.age_s = f.Number(0.0, 1e6);
  m.station = ReadStation(f);
  if (m.quality != 0 && (!m.has_position || !m.time_utc)) return std::nullopt;
  return Checked(f, m);
}

std::optional<NmeaRmc> ParseRmc(const NmeaSentence& sentence) noexcept {
  FieldReader f = Reader(sentence);
  if (f.count() < 11 || f.count() > 13) return std::nullopt;
  NmeaRmc m;
  m.time_utc = ReadTime(f);
  m.valid = f.Letter("AV") == 'A';
  m.has_position = f.LatLon(m.lat_deg, m.lon_deg);
  m.speed_mps = f.Number(0.0, kMaxSpeedKnots) * kMpsPerKnot;
  m.course_deg = f.Number(0.0, 360.0);
  const std::string_view date = f.Text();
  if (!date.empty() && date != "000000") {
    Decimal number;
    if (date.size() != 6 || !ParseDecimal(date, number) || number.decimals != 0 ||
        number.mantissa < 0) {
      return std::nullopt;
    }
    const int ddmmyy = static_cast<int>(number.mantissa);
    m.day = ddmmyy / 10'000;
    m.month = ddmmyy / 100 % 100;
    // Two digits: no GPS receiver knew a date before 1980.
    m.year = ddmmyy % 100 + (ddmmyy % 100 < 80 ? 2000 : 1900);
    if (!ValidDate(m.year, m.month, m.day)) return std::nullopt;
    m.has_date = true;
  }
  m.magnetic_variation_deg = f.Number(-180.0, 360.0);
  if (f.Letter("EW") == 'W') m.magnetic_variation_deg = -m.magnetic_variation_deg;
  if (!f.done()) m.mode = f.Letter(kModes);
  if (!f.done()) m.nav_status = f.Letter("SCUV");
  if (m.valid && (!m.has_position || !m.time_utc)) return std::nullopt;
  return Checked(f, m);
}

std::optional<NmeaVtg> ParseVtg(const NmeaSentence& sentence) noexcept {
  FieldReader f = Reader(sentence);
  const int count = f.count();
  if (count != 4 && count != 8 && count != 9) return std::nullopt;
  const bool with_units = count != 4;
  NmeaVtg m;
  m.course_true_deg = f.Number(0.0, 360.0);
  if (with_units) f.Letter("T");
  m.course_magnetic_deg = f.Number(0.0, 360.0);
  if (with_units) f.Letter("M");
  m.speed_mps = ReadSpeed(f, with_units);
  if (!f.done()) m.mode = f.Letter(kModes);
  return Checked(f, m);
}

std::optional<NmeaGst> ParseGst(const NmeaSentence& sentence) noexcept {
  FieldReader f = Reader(sentence);
  if (f.count() != 8) return std::nullopt;
  NmeaGst m;
  m.time_utc = ReadTime(f);
  m.rms_m = f.Number(0.0, kMaxSigmaM);
  m.semi_major_m = f.Number(0.0, kMaxSigmaM);
  m.semi_minor_m = f.Number(0.0, kMaxSigmaM);
  m.orientation_deg = f.Number(-360.0, 360.0);
  m.lat_sd_m = f.Number(0.0, kMaxSigmaM);
  m.lon_sd_m = f.Number(0.0, kMaxSigmaM);
  m.alt_sd_m = f.Number(0.0, kMaxSigmaM);
  return Checked(f, m);
}

std::optional<NmeaGsa> ParseGsa(const NmeaSentence& sentence) noexcept {
  FieldReader f = Reader(sentence);
  if (f.count() != 17 && f.count() != 18) return std::nullopt;
  NmeaGsa m;
  m.selection = f.Letter("MA");
  m.fix = static_cast<std::uint8_t>(f.Integer(1, 3, 1));
  for (int i = 0; i < 12; ++i) {
    const std::int64_t id = f.Integer(0, 9999, 0);
    if (id > 0) m.satellites[m.count++] = static_cast<std::uint16_t>(id);
  }
  m.pdop = f.Number(0.0, kMaxDop);
  m.hdop = f.Number(0.0, kMaxDop);
  m.vdop = f.Number(0.0, kMaxDop);
  if (!f.done()) m.system = static_cast<int>(f.Hex(15, kNoInteger));
  return Checked(f, m);
}

std::optional<NmeaGsv> ParseGsv(const NmeaSentence& sentence) noexcept {
  FieldReader f = Reader(sentence);
  const int satellites = (f.count() - 3) / 4;
  const int extra = f.count() - 3 - 4 * satellites;
  if (f.count() < 3 || satellites > 4 || extra > 1) return std::nullopt;
  NmeaGsv m;
  m.total = static_cast<std::uint8_t>(f.Integer(0, 99, 0));
  m.index = static_cast<std::uint8_t>(f.Integer(0, 99, 0));
  m.in_view = static_cast<int>(f.Integer(0, 999, kNoInteger));
  for (int i = 0; i < satellites; ++i) {
    NmeaGsv::Satellite s;
    s.id = static_cast<int>(f.Integer(0, 9999, kNoInteger));
    s.elevation_deg = static_cast<int>(f.Integer(-90, 99, kNoElevation));
    s.azimuth_deg = static_cast<int>(f.Integer(0, 360, kNoInteger));
    s.snr_dbhz = static_cast<int>(f.Integer(0, 127, kNoInteger));
    if (s.id != kNoInteger) m.satellites[m.count++] = s;
  }
  if (extra == 1) m.signal = static_cast<int>(f.Hex(15, kNoInteger));
  if (m.index > m.total) return std::nullopt;
  return Checked(f, m);
}

std::optional<NmeaZda> ParseZda(const NmeaSentence& sentence) noexcept {
  FieldReader f = Reader(sentence);
  if (f.count() != 6) return std::nullopt;
  NmeaZda m;
  m.time_utc = ReadTime(f);
  m.day = static_cast<int>(f.Integer(0, 31, 0));
  m.month = static_cast<int>(f.Integer(0, 12, 0));
  m.year = static_cast<int>(f.Integer(0, 9999, 0));
  m.zone_hours = static_cast<int>(f.Integer(-14, 14, 0));
  m.zone_minutes = static_cast<int>(f.Integer(-59, 59, 0));
  m.has_date = m.day != 0 && m.month != 0 && m.year != 0;
  if (m.has_date && (m.year < 1980 || !ValidDate(m.year, m.month, m.day))) return std::nullopt;
  return Checked(f, m);
}

std::optional<NmeaHeading> ParseHdt(const NmeaSentence& sentence) noexcept {
  FieldReader f = Reader(sentence);
  if (f.count() != 2) return std::nullopt;
  NmeaHeading m;
  m.true_heading_deg = f.Number(0.0, 360.0);
  f.Letter("T");
  return Checked(f, m);
}

std::optional<NmeaHeading> ParseThs(const NmeaSentence& sentence) noexcept {
  FieldReader f = Reader(sentence);
  if (f.count() != 2) return std::nullopt;
  NmeaHeading m;
  m.true_heading_deg = f.Number(0.0, 360.0);
  m.mode = f.Letter("AEMSV", false);
  return Checked(f, m);
}

std::optional<NmeaGbs> ParseGbs(const NmeaSentence& sentence) noexcept {
  FieldReader f = Reader(sentence);
  if (f.count() != 8 && f.count() != 10) return std::nullopt;
  NmeaGbs m;
  m.time_utc = ReadTime(f);
  m.lat_sd_m = f.Number(0.0, kMaxSigmaM);
  m.lon_sd_m = f.Number(0.0, kMaxSigmaM);
  m.alt_sd_m = f.Number(0.0, kMaxSigmaM);
  m.failed_satellite = static_cast<int>(f.Integer(0, 9999, kNoInteger));
  m.missed_probability = f.Number(0.0, 1.0);
  m.bias_m = f.Number(-kMaxSigmaM, kMaxSigmaM);
  m.bias_sd_m = f.Number(0.0, kMaxSigmaM);
  if (!f.done()) {
    m.system = static_cast<int>(f.Hex(15, kNoInteger));
    m.signal = static_cast<int>(f.Hex(255, kNoInteger));
  }
  return Checked(f, m);
}

NmeaBody ParseNmea(const NmeaSentence& sentence) noexcept {
  const std::string_view type = sentence.type();
  if (type.size() != 3 || sentence.is_proprietary()) return NmeaOther{};
  switch (Code(type)) {
    case Code("GGA"):
      return Body(ParseGga(sentence));
    case Code("RMC"):
      return Body(ParseRmc(sentence));
    case Code("VTG"):
      return Body(ParseVtg(sentence));
    case Code("GST"):
      return Body(ParseGst(sentence));
    case Code("GSA"):
      return Body(ParseGsa(sentence));
    case Code("GSV"):
      return Body(ParseGsv(sentence));
    case Code("ZDA"):
      return Body(ParseZda(sentence));
    case Code("HDT"):
      return Body(ParseHdt(sentence));
    case Code("THS"):
      return Body(ParseThs(sentence));
    case Code("GBS"):
      return Body(ParseGbs(sentence));
    default:
      return NmeaOther{};
  }
}

}  // namespace kawara::drivers
