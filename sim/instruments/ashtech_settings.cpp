#include "sim/instruments/ashtech_settings.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <vector>

namespace kawara::sim {
namespace {

using Fields = std::vector<std::string_view>;

constexpr std::array<int, 10> kBauds{300, 600, 1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200};

constexpr std::array<const char*, static_cast<std::size_t>(AshtechMessage::kCount)> kMessageNames{
    "GGA", "RMC", "VTG", "GST", "GSA", "POS", "CBN", "LTN", "ZDA", "PTT", "TTT", "ALM", "DAL",
    "GDC", "GLL", "GRS", "GSN", "GSV", "GXP", "MSG", "RRE", "SAT", "UTM", "XDR", "XTE"};

/// How this receiver names itself: family, channels, firmware, options (E: event marker, P: PPS, J:
/// RTK rover, U: RTCM rover, 3: 10 Hz), boot version. "SIM" where a real one has its version
/// numbers.
constexpr const char* kIdentity = "PASHR,RID,UZ,30,SIM0,BUEPMFT3J-,SIM1";

std::uint8_t Xor(std::string_view text) {
  std::uint8_t sum = 0;
  for (const char c : text) sum = static_cast<std::uint8_t>(sum ^ static_cast<std::uint8_t>(c));
  return sum;
}

Fields SplitCommas(std::string_view text) {
  Fields fields;
  for (;;) {
    const std::size_t comma = text.find(',');
    fields.push_back(text.substr(0, comma));
    if (comma == std::string_view::npos) return fields;
    text.remove_prefix(comma + 1);
  }
}

std::optional<int> PortNamed(std::string_view letter) {
  if (letter.size() != 1 || letter[0] < 'A' || letter[0] > 'D') return std::nullopt;
  return letter[0] - 'A';
}

std::optional<double> Number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<core::Duration> SecondsWithin(std::string_view text, double low, double high) {
  const std::optional<double> value = Number(text);
  if (!value || !(*value >= low && *value <= high)) return std::nullopt;
  return core::DurationFromSeconds(*value);
}

bool SetNmea(const Fields& f, AshtechSettings& s) {
  if (f.size() == 4 && f[2] == "PER") {
    const auto period = SecondsWithin(f[3], 0.1, 999.0);
    if (period) s.nmea_period = *period;
    return period.has_value();
  }
  if (f.size() != 5 || (f[4] != "ON" && f[4] != "OFF")) return false;
  const bool on = f[4] == "ON";
  const std::optional<int> port = PortNamed(f[3]);
  if (!port) return false;
  AshtechMessages& messages = s.ports[static_cast<std::size_t>(*port)].on;
  const auto cbn = static_cast<std::size_t>(AshtechMessage::kCbn);
  if (f[2] == "ALL" && !on) {
    const bool keep_cbn = messages[cbn];  // CBN belongs to OUT, not to NME
    messages.reset();
    messages[cbn] = keep_cbn;
    return true;
  }
  const auto message = AshtechMessageNamed(f[2]);
  if (!message || *message == AshtechMessage::kCbn) return false;
  messages[static_cast<std::size_t>(*message)] = on;
  return true;
}

/// OUT,c[,CBN[,ASC]]: lists ALL raw messages of the port; those not named stop. Only CBN in ASCII
/// is known here.
bool SetOut(const Fields& f, AshtechSettings& s) {
  const std::optional<int> port = f.size() >= 3 ? PortNamed(f[2]) : std::nullopt;
  if (!port) return false;
  bool cbn = false;
  for (std::size_t i = 3; i < f.size(); ++i) {
    if (f[i] == "CBN") {
      cbn = true;
    } else if (f[i] != "ASC" || i + 1 != f.size()) {
      return false;
    }
  }
  s.ports[static_cast<std::size_t>(*port)].on[static_cast<std::size_t>(AshtechMessage::kCbn)] = cbn;
  return true;
}

bool SetRtc(const Fields& f, AshtechSettings& s) {
  if (f.size() == 3 && (f[2] == "OFF" || f[2] == "INI")) {
    if (f[2] == "OFF") s.corrections_port.reset();
    return true;
  }
  if (f.size() != 4) return false;
  if (f[2] == "REM") {
    const std::optional<int> port = PortNamed(f[3]);
    if (!port) return false;
    s.corrections_port = port;
    s.rover = s.cpd_works = false;  // the order that disables CPD: REM after MOD
    return true;
  }
  if (f[2] == "MAX") {
    const auto age = SecondsWithin(f[3], 0.0, 1199.0);
    if (age) s.corrections_max_age = *age;
    return age.has_value();
  }
  return f[2] == "F18" || f[2] == "STI" || f[2] == "SEQ" || f[2] == "QAF" || f[2] == "TYP" ||
         f[2] == "AUT";
}

bool SetCpd(const Fields& f, AshtechSettings& s) {
  if (f.size() < 3) return false;
  if (f[2] == "RST") return f.size() == 3;
  if (f.size() != 4) return false;
  if (f[2] == "MOD") {
    if (f[3] != "ROV" && f[3] != "OFF") return false;  // a base it cannot be here
    s.rover = f[3] == "ROV";
    s.cpd_works = s.rover && s.corrections_port.has_value();
    return true;
  }
  if (f[2] == "FST") {
    if (f[3] != "ON" && f[3] != "OFF") return false;
    s.fast_cpd = f[3] == "ON";
    return true;
  }
  if (f[2] == "MAX") return SecondsWithin(f[3], 0.0, 1199.0).has_value();
  if (f[2] == "AFP") return SecondsWithin(f[3], 90.0, 99.9).has_value();
  if (f[2] == "DYN") return SecondsWithin(f[3], 0.0, 5.0).has_value();
  return false;
}

bool SetPps(const Fields& f, AshtechSettings& s) {
  if (f.size() < 3 || f.size() > 5) return false;
  const auto period = SecondsWithin(f[2], 0.0, 60.0);
  const auto offset_ms = f.size() > 3 ? Number(f[3]) : std::optional<double>(0.0);
  const std::string_view edge = f.size() > 4 ? f[4] : "R";
  if (!period || !offset_ms || !(*offset_ms > -1000.0 && *offset_ms < 1000.0)) return false;
  if (edge != "R" && edge != "F") return false;
  s.pps_period = *period;
  s.pps_offset = core::DurationFromSeconds(*offset_ms * 1e-3);
  s.pps_edge = edge[0];
  return true;
}

bool SetSpeed(const Fields& f, AshtechSettings& s) {
  const std::optional<int> port = f.size() == 4 ? PortNamed(f[2]) : std::nullopt;
  if (!port || f[3].size() != 1 || f[3][0] < '0' || f[3][0] > '9') return false;
  s.ports[static_cast<std::size_t>(*port)].baud_code = f[3][0] - '0';
  return true;
}

bool Set(const Fields& f, AshtechSettings& s, AshtechReply& reply) {
  if (f.size() < 2) return false;
  if (f[1] == "NME") return SetNmea(f, s);
  if (f[1] == "OUT") return SetOut(f, s);
  if (f[1] == "RTC") return SetRtc(f, s);
  if (f[1] == "CPD") return SetCpd(f, s);
  if (f[1] == "PPS") return SetPps(f, s);
  if (f[1] == "SPD") return SetSpeed(f, s);
  if (f[1] == "PHE" && f.size() == 3 && (f[2] == "R" || f[2] == "F")) {
    s.event_edge = f[2][0];
    return true;
  }
  if (f[1] == "RCI" && f.size() == 3) {
    const auto period = SecondsWithin(f[2], 0.1, 999.0);
    if (period) s.raw_period = *period;
    return period.has_value();
  }
  if (f[1] == "SAV" && f.size() == 3 && (f[2] == "Y" || f[2] == "N")) {
    reply.save = f[2] == "Y";
    return true;
  }
  if (f[1] == "RST" && f.size() == 2) {
    reply.reset = true;
    return true;
  }
  return false;
}

/// The real PAR is a page for people; this one has its layout, with the lines that apply here.
std::string ParameterPage(const AshtechSettings& s) {
  std::string page =
      "DIF_RTCM MODE: " + std::string(s.corrections_port ? "REMOTE" : "OFF") + "  PRT:" +
      (s.corrections_port ? std::string(1, static_cast<char>('A' + *s.corrections_port)) : "-") +
      "\r\nCPD MODE: " + (s.rover ? "ROVER" : "OFF") + "  FST:" + (s.fast_cpd ? "ON" : "OFF") +
      "\r\n";
  std::array<char, 80> line{};
  std::snprintf(line.data(), line.size(),
                "RCI:%05.1f  PER:%05.1f\r\nNMEA:", core::ToSeconds(s.raw_period),
                core::ToSeconds(s.nmea_period));
  page += line.data();
  for (const char* name : kMessageNames) page += " " + std::string(name);
  page += "\r\n";
  for (std::size_t port = 0; port < s.ports.size(); ++port) {
    page += "PRT" + std::string(1, static_cast<char>('A' + port)) + ":";
    for (std::size_t i = 0; i < kMessageNames.size(); ++i)
      page += s.ports[port].on[i] ? "  ON" : " OFF";
    page += "\r\n";
  }
  return page;
}

bool Query(const Fields& f, int port, const AshtechSettings& s, AshtechReply& reply) {
  if (f.size() < 2 || f.size() > 3) return false;
  // A third field names the port to answer on; another than ours would answer where nobody is.
  const std::optional<int> to = f.size() == 3 ? PortNamed(f[2]) : port;
  if (!to) return false;
  if (f[1] == "PRT") {
    const AshtechSettings::Port& asked = s.ports[static_cast<std::size_t>(*to)];
    reply.text = WithChecksum("PASHR,PRT," + std::string(1, static_cast<char>('A' + *to)) + "," +
                              std::to_string(asked.baud_code));
    return true;
  }
  std::string text;
  std::array<char, 48> line{};
  if (f[1] == "RID") {
    text = WithChecksum(kIdentity);
  } else if (f[1] == "PAR") {
    text = ParameterPage(s);
  } else if (f[1] == "PHE") {
    text = WithChecksum("PASHR,PHE," + std::string(1, s.event_edge));
  } else if (f[1] == "PPS") {
    std::snprintf(line.data(), line.size(), "PASHR,PPS,%g,%g,%c", core::ToSeconds(s.pps_period),
                  core::ToSeconds(s.pps_offset) * 1e3, s.pps_edge);
    text = WithChecksum(line.data());
  } else if (const auto message = AshtechMessageNamed(f[1])) {
    if (*message == AshtechMessage::kTtt || *message > AshtechMessage::kTtt) return false;
    if (*to == port) reply.once = message;
    return true;
  } else {
    return false;
  }
  if (*to == port) reply.text = text;
  return true;
}

}  // namespace

std::optional<AshtechMessage> AshtechMessageNamed(std::string_view three_letters) {
  const auto* const found = std::find(kMessageNames.begin(), kMessageNames.end(), three_letters);
  if (found == kMessageNames.end()) return std::nullopt;
  return static_cast<AshtechMessage>(found - kMessageNames.begin());
}

const char* ToString(AshtechMessage message) {
  return kMessageNames[static_cast<std::size_t>(message)];
}

int AshtechBaud(int code) {
  return code >= 0 && code <= 9 ? kBauds[static_cast<std::size_t>(code)] : 0;
}

std::optional<int> AshtechBaudCode(int baud_bps) {
  const auto* const found = std::find(kBauds.begin(), kBauds.end(), baud_bps);
  if (found == kBauds.end()) return std::nullopt;
  return static_cast<int>(found - kBauds.begin());
}

std::string WithChecksum(std::string_view body) {
  std::array<char, 8> tail{};
  std::snprintf(tail.data(), tail.size(), "*%02X\r\n", static_cast<unsigned>(Xor(body)));
  return "$" + std::string(body) + tail.data();
}

AshtechReply ObeyAshtech(std::string_view line, int port, AshtechSettings& settings) {
  AshtechReply reply;
  bool good = line.starts_with('$');
  if (good) line.remove_prefix(1);
  if (const std::size_t star = line.find('*'); star != std::string_view::npos) {
    unsigned stated = 0;
    const std::string_view digits = line.substr(star + 1);
    const auto [end, error] =
        std::from_chars(digits.data(), digits.data() + digits.size(), stated, 16);
    good = good && digits.size() == 2 && error == std::errc() && end == digits.data() + 2 &&
           stated == Xor(line.substr(0, star));
    line = line.substr(0, star);
  }
  const Fields fields = SplitCommas(line);
  if (good && fields[0] == "PASHS") {
    AshtechSettings changed = settings;
    good = Set(fields, changed, reply);
    if (good) {
      settings = reply.reset ? AshtechSettings{} : changed;
      reply.text = WithChecksum("PASHR,ACK");
    }
  } else if (good && fields[0] == "PASHQ") {
    good = Query(fields, port, settings, reply);
  } else {
    good = false;
  }
  if (!good) reply = {.text = WithChecksum("PASHR,NAK"), .once = {}, .reset = false, .save = {}};
  return reply;
}

}  // namespace kawara::sim
