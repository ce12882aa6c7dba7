#include "gis/record_check.hpp"

#include <zlib.h>

#include <array>
#include <cmath>
#include <cstdio>

namespace kawara::gis {
namespace {

using core::ErrorCode;
using core::Fail;

const core::GpsTime kEarliest = core::ToGps(core::FromCivil({.year = 2000}));
const core::GpsTime kLatest = core::ToGps(core::FromCivil({.year = 2200}));

tl::unexpected<core::Error> Refuse(const std::string& why) {
  return Fail(ErrorCode::kInvalidArgument, why);
}

bool FiniteOrNan(double v) { return std::isnan(v) || std::isfinite(v); }
bool Within(double v, double low, double high) { return v >= low && v <= high; }  // false for NaN

core::Expected<void> CheckNames(const std::string& robot, const std::string& mission) {
  if (robot.empty() || !IsCleanText(robot, kMaxNameBytes)) return Refuse("robot: no usable name");
  if (mission.empty() || !IsCleanText(mission, kMaxNameBytes))
    return Refuse("mission: no usable name");
  return {};
}

core::Expected<void> CheckTime(core::GpsTime t) {
  if (t < kEarliest || t > kLatest)
    return Refuse("gps_ns = " + std::to_string(t.ns()) + ": not within 2000..2200");
  return {};
}

core::Expected<void> CheckPose(const PoseFields& p, bool has_position) {
  if (auto time = CheckTime(p.time); !time) return time;
  if (!has_position) return {};
  if (!Within(p.lat_deg, -90, 90)) return Refuse("lat_deg out of -90..90");
  if (!Within(p.lon_deg, -180, 180)) return Refuse("lon_deg out of -180..180");
  if (!Within(p.h_ellipsoidal_m, -1000, 100000)) return Refuse("h_ellipsoidal_m out of range");
  if (!Within(p.roll_deg, -360, 360) || !Within(p.pitch_deg, -360, 360) ||
      !Within(p.yaw_deg, -360, 360))
    return Refuse("attitude out of -360..360 deg");
  for (const double v : p.velocity_enu_mps)
    if (!FiniteOrNan(v)) return Refuse("velocity infinite");
  for (const double v : p.position_sd_enu_m)
    if (!FiniteOrNan(v) || v < 0) return Refuse("position accuracy negative or infinite");
  for (const double v : p.attitude_sd_deg)
    if (!FiniteOrNan(v) || v < 0) return Refuse("attitude accuracy negative or infinite");
  if (!FiniteOrNan(p.gnss_age_s)) return Refuse("gnss_age_s infinite");
  if (static_cast<unsigned>(p.rtk) > static_cast<unsigned>(core::RtkState::kDeadReckoning))
    return Refuse("rtk_state unknown");
  return {};
}

/// Bytes of the UTF-8 character that text starts with; 0: none, or a control character.
std::size_t CleanCharacter(std::string_view text) {
  const auto byte = [&text](std::size_t i) -> unsigned {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
  };
  const unsigned lead = byte(0);
  if (lead < 0x80) return lead >= 0x20 && lead != 0x7f ? 1 : 0;
  const std::size_t length = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4) return 0;
  unsigned code = lead & (0xffU >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0U) != 0x80U) return 0;
    code = code << 6 | (byte(i) & 0x3fU);
  }
  constexpr std::array<unsigned, 5> kLeast{0, 0, 0x80, 0x800, 0x10000};
  if (code < kLeast[length] || code > 0x10ffff) return 0;         // overlong, beyond Unicode
  if (code >= 0xd800 && code <= 0xdfff) return 0;                 // surrogates
  if (code < 0xa0 || code == 0x2028 || code == 0x2029) return 0;  // C1 controls, line separators
  return length;
}

}  // namespace

bool IsCleanText(std::string_view text, std::size_t max_bytes) {
  if (text.size() > max_bytes) return false;
  while (!text.empty()) {
    const std::size_t n = CleanCharacter(text);
    if (n == 0) return false;
    text.remove_prefix(n);
  }
  return true;
}

std::string CleanText(std::string_view text, std::size_t max_bytes) {
  std::string clean;
  while (!text.empty()) {
    const std::size_t n = CleanCharacter(text);
    if (clean.size() + std::max<std::size_t>(n, 1) > max_bytes) break;
    clean += n == 0 ? std::string_view("?") : text.substr(0, n);
    text.remove_prefix(std::max<std::size_t>(n, 1));
  }
  return clean;
}

std::string SafePathName(std::string_view name) {
  std::string safe;
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '-' || c == '_' || (c == '.' && !safe.empty());
    safe += plain ? c : '_';
  }
  if (safe == name && !safe.empty()) return safe;
  uLong crc = crc32_z(0, nullptr, 0);
  for (const char c : name) {
    const Bytef byte = static_cast<unsigned char>(c);
    crc = crc32_z(crc, &byte, 1);
  }
  std::array<char, 16> tail{};
  std::snprintf(tail.data(), tail.size(), "-%08lx", crc);
  return safe + tail.data();
}

core::Expected<JpegSize> CheckJpeg(std::span<const std::uint8_t> bytes) {
  const auto torn = [](const char* what) { return Fail(ErrorCode::kFormat, what); };
  if (bytes.size() < 4 || bytes[0] != 0xff || bytes[1] != 0xd8) return torn("JPEG without SOI");
  if (bytes[bytes.size() - 2] != 0xff || bytes[bytes.size() - 1] != 0xd9)
    return torn("JPEG cut short: no EOI at the end");
  JpegSize size;
  std::size_t at = 2;
  while (at + 4 <= bytes.size()) {
    if (bytes[at] != 0xff) return torn("JPEG with a damaged segment");
    const unsigned marker = bytes[at + 1];
    if (marker == 0xff) {  // fill byte
      ++at;
      continue;
    }
    const std::size_t length = static_cast<std::size_t>(bytes[at + 2]) << 8 | bytes[at + 3];
    if (length < 2 || at + 2 + length > bytes.size()) return torn("JPEG segment beyond the end");
    const bool frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame) {
      if (length < 8) return torn("JPEG frame header too short");
      size.height = static_cast<std::uint32_t>(bytes[at + 5]) << 8 | bytes[at + 6];
      size.width = static_cast<std::uint32_t>(bytes[at + 7]) << 8 | bytes[at + 8];
    }
    if (marker == 0xda) {
      if (size.width == 0 || size.height == 0) return torn("JPEG without a size before its scan");
      return size;
    }
    at += 2 + length;
  }
  return torn("JPEG without a scan");
}

core::Expected<void> CheckRecord(const PoseRecord& record) {
  if (auto names = CheckNames(record.robot, record.mission); !names) return names;
  return CheckPose(record.pose, true);
}

core::Expected<void> CheckRecord(const PanoramaRecord& record) {
  if (auto names = CheckNames(record.robot, record.mission); !names) return names;
  constexpr std::int64_t kLastEpoch = 1'000'000'000'000;
  if (record.epoch < 1 || record.epoch > kLastEpoch)
    return Refuse("epoch = " + std::to_string(record.epoch) + ": out of 1..1e12");
  if (record.stage != PictureStage::kPreview && record.stage != PictureStage::kFull)
    return Refuse("stage unknown");
  if (static_cast<unsigned>(record.reason) >
      static_cast<unsigned>(core::PictureReason::kFreeRunning))
    return Refuse("reason unknown");
  if (!IsCleanText(record.projection, kMaxNameBytes)) return Refuse("projection: no usable name");
  if (auto pose = CheckPose(record.pose, record.has_position); !pose) return pose;
  if (!record.jpeg || record.jpeg->size() > kMaxJpegBytes)
    return Refuse("picture missing or larger than 64 MiB");
  const auto size = CheckJpeg(*record.jpeg);
  if (!size) return Refuse(size.error().message);
  if (size->width != record.width || size->height != record.height)
    return Refuse("JPEG is " + std::to_string(size->width) + " x " + std::to_string(size->height) +
                  ", packet says " + std::to_string(record.width) + " x " +
                  std::to_string(record.height));
  return {};
}

core::Expected<void> CheckRecord(const EventRecord& record) {
  if (auto names = CheckNames(record.robot, record.mission); !names) return names;
  if (record.name.empty() || !IsCleanText(record.name, kMaxNameBytes))
    return Refuse("event name unusable");
  if (!IsCleanText(record.text, kMaxTextBytes)) return Refuse("event text unusable");
  if (record.severity < 0 || record.severity > 3) return Refuse("severity out of 0..3");
  if (record.time.IsSet()) return CheckTime(record.time);
  return {};
}

}  // namespace kawara::gis
