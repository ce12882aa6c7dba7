#include "drivers/ntrip_request.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string_view>

#include "core/base64.hpp"

namespace kawara::drivers {
namespace {

constexpr const char* kUserAgent =
    "NTRIP Kawaraban/1.0";  // casters of version 1 insist on the word NTRIP

bool IsPrintable(std::string_view text, bool space_allowed) {
  return std::all_of(text.begin(), text.end(), [&](char c) {
    const auto u = static_cast<unsigned char>(c);
    return u > 0x20 && u != 0x7F ? true : (u == 0x20 && space_allowed);
  });
}

/// ddmm.mmmmm or dddmm.mmmmm; rounds before it splits, so that 59.999999 minutes carry over.
std::string DegreesMinutes(double angle_deg, int degree_digits) {
  constexpr double kUnitsPerMinute = 1e5;
  const auto units = std::llround(std::abs(angle_deg) * 60.0 * kUnitsPerMinute);
  const auto degrees = units / static_cast<long long>(60 * kUnitsPerMinute);
  const double minutes =
      static_cast<double>(units % static_cast<long long>(60 * kUnitsPerMinute)) / kUnitsPerMinute;
  char text[32];
  std::snprintf(text, sizeof(text), "%0*lld%08.5f", degree_digits, degrees, minutes);
  return text;
}

int GgaQuality(core::RtkState rtk) {
  switch (rtk) {
    case core::RtkState::kNone:
      return 0;
    case core::RtkState::kAutonomous:
      return 1;
    case core::RtkState::kCodeDifferential:
      return 2;
    case core::RtkState::kFixed:
      return 4;
    case core::RtkState::kFloat:
      return 5;
    case core::RtkState::kDeadReckoning:
      return 6;
  }
  return 0;
}

}  // namespace

core::Expected<std::string> MakeNtripRequest(const NtripRequest& r) {
  using core::ErrorCode;
  if (r.host.empty()) return core::Fail(ErrorCode::kInvalidArgument, "ntrip: no host given");
  if (!IsPrintable(r.host, false) || !IsPrintable(r.mountpoint, false)) {
    return core::Fail(ErrorCode::kInvalidArgument,
                      "ntrip: host or mountpoint contains a space or control character");
  }
  if (!IsPrintable(r.user, true) || !IsPrintable(r.password, true) ||
      r.user.find(':') != std::string::npos) {
    return core::Fail(ErrorCode::kInvalidArgument,
                      "ntrip: user or password contains a control character, or the user a colon");
  }
  if (!IsPrintable(r.gga, false)) {
    return core::Fail(ErrorCode::kInvalidArgument,
                      "ntrip: the GGA sentence contains a space or control character");
  }
  if (r.version != 1 && r.version != 2) {
    return core::Fail(ErrorCode::kInvalidArgument, "ntrip: version must be 1 or 2");
  }
  const bool v2 = r.version == 2;
  const std::string_view mountpoint = !r.mountpoint.empty() && r.mountpoint.front() == '/'
                                          ? std::string_view(r.mountpoint).substr(1)
                                          : r.mountpoint;
  std::string text;
  text.append("GET /").append(mountpoint).append(v2 ? " HTTP/1.1\r\n" : " HTTP/1.0\r\n");
  if (v2) {
    const bool ipv6 = r.host.find(':') != std::string::npos;
    text.append("Host: ").append(ipv6 ? "[" + r.host + "]" : r.host);
    text.append(":").append(std::to_string(r.port)).append("\r\nNtrip-Version: Ntrip/2.0\r\n");
  }
  text.append("User-Agent: ").append(kUserAgent).append("\r\n");
  if (!r.user.empty()) {
    text.append("Authorization: Basic ")
        .append(core::Base64(r.user + ":" + r.password))
        .append("\r\n");
  }
  if (v2 && !r.gga.empty()) text.append("Ntrip-GGA: ").append(r.gga).append("\r\n");
  if (v2) text.append("Connection: close\r\n");
  return text.append("\r\n");
}

std::optional<std::string> MakeGga(const core::GnssFix& fix, const core::LeapSeconds& leaps) {
  if (!fix.has_position || fix.rtk == core::RtkState::kNone) return std::nullopt;
  const core::CivilTime t = core::ToCivil(core::ToUtc(fix.time, leaps));
  const double lat_deg = fix.antenna.lat_rad * core::kDegFromRad;
  const double lon_deg = fix.antenna.lon_rad * core::kDegFromRad;
  const bool has_separation = std::isfinite(fix.geoid_separation_m);
  const double hdop = std::isfinite(fix.hdop) && fix.hdop > 0.0 ? std::min(fix.hdop, 99.9) : 1.0;
  char body[160];
  std::snprintf(body, sizeof(body), "GPGGA,%02d%02d%02d.%02d,%s,%c,%s,%c,%d,%02d,%.1f,%.3f,M,",
                t.hour, t.minute, std::min(t.second, 59),
                static_cast<int>(t.nanosecond / 10'000'000), DegreesMinutes(lat_deg, 2).c_str(),
                lat_deg < 0 ? 'S' : 'N', DegreesMinutes(lon_deg, 3).c_str(),
                lon_deg < 0 ? 'W' : 'E', GgaQuality(fix.rtk), std::min<int>(fix.satellites, 99),
                hdop,
                fix.antenna.h_ellipsoidal_m - (has_separation ? fix.geoid_separation_m : 0.0));
  std::string text = body;
  if (has_separation) {
    std::snprintf(body, sizeof(body), "%.3f", fix.geoid_separation_m);
    text += body;
  }
  text += ",M,,";
  unsigned checksum = 0;
  for (const char c : text) checksum ^= static_cast<unsigned char>(c);
  std::snprintf(body, sizeof(body), "*%02X", checksum);
  return "$" + text + body;
}

}  // namespace kawara::drivers
