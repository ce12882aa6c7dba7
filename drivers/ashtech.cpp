#include "drivers/ashtech.hpp"

#include <algorithm>

namespace kawara::drivers {
namespace {

constexpr std::array<int, 10> kBauds{300, 600, 1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200};

constexpr std::uint32_t Code(std::string_view type) {
  std::uint32_t code = 0;
  for (const char c : type) code = code << 8 | static_cast<std::uint8_t>(c);
  return code;
}

std::optional<core::Duration> ReadTime(FieldReader& f) {
  core::Duration time{};
  if (!f.TimeOfDay(time)) return std::nullopt;
  return time;
}

template <class T>
AshtechBody Checked(const FieldReader& f, const T& value) {
  if (!f.ok()) return AshtechInvalid{};
  return value;
}

AshtechBody ParsePos(FieldReader& f) {
  if (f.count() != 17 && f.count() != 18) return AshtechInvalid{};
  AshtechPos m;
  m.type = static_cast<int>(f.Integer(0, 99, -1));
  m.satellites = static_cast<int>(f.Integer(0, 255, -1));
  m.time_utc = ReadTime(f);
  m.has_position = f.LatLon(m.lat_deg, m.lon_deg);
  m.height_m = f.Number(-2000.0, 100'000.0);
  m.age_s = f.Number(0.0, 1e6);
  m.course_deg = f.Number(0.0, 360.0);
  m.speed_as_sent = f.Number(0.0, 20'000.0);
  m.vertical_as_sent = f.Number(-10'000.0, 10'000.0);
  m.pdop = f.Number(0.0, 1e5);
  m.hdop = f.Number(0.0, 1e5);
  m.vdop = f.Number(0.0, 1e5);
  m.tdop = f.Number(0.0, 1e5);
  if (!f.done()) m.tail.Append(f.Text());
  if (m.type >= 0 && (!m.has_position || !m.time_utc)) return AshtechInvalid{};
  return Checked(f, m);
}

AshtechBody ParseCbn(FieldReader& f) {
  if (f.count() != 23) return AshtechInvalid{};
  AshtechCbn m;
  m.time_utc = ReadTime(f);
  m.site.Append(f.Text());
  m.satellites = static_cast<int>(f.Integer(0, 255, -1));
  m.pdop = f.Number(0.0, 1e5);
  m.has_position = f.LatLon(m.lat_deg, m.lon_deg);
  m.h_ellipsoidal_m = f.Number(-2000.0, 100'000.0);
  m.lat_sd_m = f.Number(0.0, 1e6);
  m.lon_sd_m = f.Number(0.0, 1e6);
  m.height_sd_m = f.Number(0.0, 1e6);
  for (double& cross : m.cross_m2) cross = f.Number(-1e6, 1e6);
  const std::string_view flags = f.Text();
  if (flags.size() != m.flags.size()) return AshtechInvalid{};
  for (std::size_t i = 0; i < flags.size(); ++i) {
    if (flags[i] < '0' || flags[i] > '3') return AshtechInvalid{};
    m.flags[i] = static_cast<std::uint8_t>(flags[i] - '0');
  }
  m.east_mps = f.Number(-1000.0, 1000.0);
  m.north_mps = f.Number(-1000.0, 1000.0);
  m.up_mps = f.Number(-1000.0, 1000.0);
  m.east_sd_mps = f.Number(0.0, 1e4);
  m.north_sd_mps = f.Number(0.0, 1e4);
  m.up_sd_mps = f.Number(0.0, 1e4);
  if (m.flags[0] != 0 && (!m.has_position || !m.time_utc)) return AshtechInvalid{};
  return Checked(f, m);
}

AshtechBody ParseTimeTag(FieldReader& f, bool is_event) {
  AshtechTimeTag m;
  m.is_event = is_event;
  const std::int64_t day = f.Integer(1, 7, 0);  // 1 is Sunday
  core::Duration time{};
  const bool has_time = f.TimeOfDayWithColons(time);
  // 23:59:60 does not exist on the GPS scale.
  if (f.count() != 3 || day == 0 || !has_time || time >= core::kDay) return AshtechInvalid{};
  m.time_of_week = (day - 1) * core::kDay + time;
  return Checked(f, m);
}

AshtechBody ParseLatency(FieldReader& f) {
  AshtechLatency m;
  m.latency_s = f.Number(0.0, 1e5) * 1e-3;
  if (f.count() != 2 || !(m.latency_s >= 0.0)) return AshtechInvalid{};
  return Checked(f, m);
}

/// `before`: fields of the type's name, already counted.
AshtechBody ParseResiduals(FieldReader& f, int before) {
  AshtechResiduals m;
  const auto count = f.Integer(0, static_cast<std::int64_t>(m.satellites.size()), -1);
  if (count < 0 || f.count() != before + 1 + 2 * static_cast<int>(count) + 2)
    return AshtechInvalid{};
  for (; m.count < count; ++m.count) {
    m.satellites[m.count].id = static_cast<int>(f.Integer(0, 999, -1));
    m.satellites[m.count].residual_m = f.Number(-1e5, 1e5);
  }
  m.horizontal_rms_m = f.Number(0.0, 1e6);
  m.vertical_rms_m = f.Number(0.0, 1e6);
  return Checked(f, m);
}

AshtechBody ParseSatellites(FieldReader& f) {
  AshtechSatellites m;
  const auto count = f.Integer(0, static_cast<std::int64_t>(m.satellites.size()), -1);
  if (count < 0 || f.count() != 2 + 5 * static_cast<int>(count)) return AshtechInvalid{};
  for (; m.count < count; ++m.count) {
    AshtechSatellites::Satellite& s = m.satellites[m.count];
    s.id = static_cast<int>(f.Integer(0, 999, -1));
    s.azimuth_deg = static_cast<int>(f.Integer(0, 360, -1));
    s.elevation_deg = static_cast<int>(f.Integer(-90, 90, -1));
    s.snr_dbhz = static_cast<int>(f.Integer(0, 127, -1));
    s.used = f.Letter("U-") == 'U';
  }
  return Checked(f, m);
}

AshtechBody ParseIdentity(FieldReader& f, std::string_view fields) {
  AshtechIdentity m;
  m.text.Append(fields);
  m.model.Append(f.Text());
  if (!f.done()) f.Skip();  // channels
  if (!f.done()) m.nav_firmware.Append(f.Text());
  return Checked(f, m);
}

AshtechBody ParsePort(FieldReader& f) {
  AshtechPort m;
  m.port = f.Letter("ABCDEFGHI", false);
  m.baud_code = static_cast<int>(f.Integer(0, 99, -1));
  m.baud_bps = AshtechBaud(m.baud_code);
  return Checked(f, m);
}

AshtechBody ParsePps(FieldReader& f) {
  AshtechPps m;
  m.period_s = f.Number(0.0, 60.0, 0.0);
  m.offset_ms = f.Number(-1000.0, 1000.0, 0.0);
  m.edge = f.Letter("RF", false);
  return Checked(f, m);
}

AshtechBody ParseEventEdge(FieldReader& f) {
  AshtechEventEdge m;
  m.edge = f.Letter("RF", false);
  return Checked(f, m);
}

AshtechBody ParseText(FieldReader& f) {
  AshtechText m;
  m.code = static_cast<int>(f.Integer(0, 99'999, -1));
  while (!f.done()) {
    if (!m.text.empty()) m.text.Append(",");
    m.text.Append(f.Text());
  }
  return Checked(f, m);
}

}  // namespace

int AshtechBaud(int code) noexcept {
  return code >= 0 && code < static_cast<int>(kBauds.size())
             ? kBauds[static_cast<std::size_t>(code)]
             : 0;
}

int AshtechBaudCode(int baud_bps) noexcept {
  const auto* const it = std::find(kBauds.begin(), kBauds.end(), baud_bps);
  return it == kBauds.end() ? -1 : static_cast<int>(it - kBauds.begin());
}

std::string_view AshtechType(const NmeaSentence& sentence) noexcept {
  if (sentence.address != "PASHR" || !sentence.has_fields) return {};
  return sentence.fields.substr(0, sentence.fields.find(','));
}

AshtechBody ParseAshtech(const NmeaSentence& sentence) noexcept {
  FieldReader f(sentence.fields, sentence.has_fields);
  if (sentence.address == "GPRRE") return ParseResiduals(f, 0);
  if (sentence.address != "PASHR" || !sentence.has_fields) return AshtechOther{};
  const std::string_view type = f.Text();
  if (type.size() != 3) return AshtechOther{};
  switch (Code(type)) {
    case Code("POS"):
      return ParsePos(f);
    case Code("CBN"):
      return ParseCbn(f);
    case Code("TTT"):
      return ParseTimeTag(f, true);
    case Code("PTT"):
      return ParseTimeTag(f, false);
    case Code("LTN"):
      return ParseLatency(f);
    case Code("RRE"):
      return ParseResiduals(f, 1);
    case Code("SAT"):
      return ParseSatellites(f);
    case Code("ACK"):
      return AshtechAck{true};
    case Code("NAK"):
      return AshtechAck{false};
    case Code("RID"):
      return ParseIdentity(
          f, sentence.fields.substr(std::min<std::size_t>(4, sentence.fields.size())));
    case Code("PRT"):
      return ParsePort(f);
    case Code("PPS"):
      return ParsePps(f);
    case Code("PHE"):
      return ParseEventEdge(f);
    case Code("XMG"):
      return ParseText(f);
    default:
      return AshtechOther{};
  }
}

}  // namespace kawara::drivers
