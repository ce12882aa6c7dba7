#include "drivers/ubx.hpp"

namespace kawara::drivers {
namespace {

constexpr std::size_t kHeaderBytes = 6;
constexpr std::size_t kSumBytes = 2;
constexpr std::size_t kNavPvtBytes = 92;
constexpr std::size_t kNavTimeGpsBytes = 16;

std::uint32_t Little(const std::uint8_t* p, std::size_t bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = bytes; i > 0; --i) value = value << 8 | p[i - 1];
  return value;
}
std::int32_t LittleSigned(const std::uint8_t* p) { return static_cast<std::int32_t>(Little(p, 4)); }

UbxNavPvt DecodeNavPvt(const std::uint8_t* p) {
  UbxNavPvt m;
  m.time_of_week = core::Milliseconds(Little(p, 4));
  m.year = static_cast<int>(Little(p + 4, 2));
  m.month = p[6];
  m.day = p[7];
  m.hour = p[8];
  m.minute = p[9];
  m.second = p[10];
  m.nanosecond = LittleSigned(p + 16);
  const std::uint8_t valid = p[11];
  constexpr std::uint8_t kDateTimeResolved = 0x07;
  m.has_date = (valid & kDateTimeResolved) == kDateTimeResolved &&
               core::IsValid({m.year, m.month, m.day, m.hour, m.minute, m.second, 0});
  m.fix_type = p[20];
  m.fix_ok = (p[21] & 0x01U) != 0;
  m.differential = (p[21] & 0x02U) != 0;
  m.carrier = static_cast<std::uint8_t>(p[21] >> 6);
  m.satellites = p[23];
  m.lon_deg = LittleSigned(p + 24) / 1e7;
  m.lat_deg = LittleSigned(p + 28) / 1e7;
  m.h_ellipsoidal_m = LittleSigned(p + 32) / 1e3;
  m.altitude_msl_m = LittleSigned(p + 36) / 1e3;
  m.horizontal_sd_m = Little(p + 40, 4) / 1e3;
  m.vertical_sd_m = Little(p + 44, 4) / 1e3;
  m.north_mps = LittleSigned(p + 48) / 1e3;
  m.east_mps = LittleSigned(p + 52) / 1e3;
  m.down_mps = LittleSigned(p + 56) / 1e3;
  m.ground_speed_mps = LittleSigned(p + 60) / 1e3;
  m.course_deg = LittleSigned(p + 64) / 1e5;
  m.speed_sd_mps = Little(p + 68, 4) / 1e3;
  m.pdop = Little(p + 76, 2) / 1e2;
  return m;
}

UbxNavTimeGps DecodeNavTimeGps(const std::uint8_t* p) {
  UbxNavTimeGps m;
  m.time_of_week = core::Milliseconds(Little(p, 4)) + core::Nanoseconds(LittleSigned(p + 4));
  m.week = static_cast<std::int16_t>(Little(p + 8, 2));
  m.gps_minus_utc_s = static_cast<std::int8_t>(p[10]);
  m.week_valid = (p[11] & 0x02U) != 0;
  m.leap_seconds_valid = (p[11] & 0x04U) != 0;
  return m;
}

}  // namespace

UbxProbeResult UbxProbe(std::span<const std::uint8_t> head) noexcept {
  if (head.empty() || head[0] != 0xB5) return {};
  if (head.size() > 1 && head[1] != 0x62) return {};
  if (head.size() < kHeaderBytes) return {UbxMatch::kNeedMore, kHeaderBytes};
  const std::size_t length = kHeaderBytes + Little(head.data() + 4, 2) + kSumBytes;
  if (length > kUbxMaxBytes) return {};
  if (head.size() < length) return {UbxMatch::kNeedMore, length};
  std::uint8_t a = 0;
  std::uint8_t b = 0;
  for (std::size_t i = 2; i < length - kSumBytes; ++i) {
    a = static_cast<std::uint8_t>(a + head[i]);
    b = static_cast<std::uint8_t>(b + a);
  }
  const bool good = head[length - 2] == a && head[length - 1] == b;
  return {good ? UbxMatch::kFrame : UbxMatch::kBadChecksum, length};
}

UbxMessage DecodeUbx(std::span<const std::uint8_t> frame) noexcept {
  UbxMessage m;
  if (frame.size() < kHeaderBytes + kSumBytes) return m;
  m.message_class = frame[2];
  m.id = frame[3];
  const auto payload = frame.subspan(kHeaderBytes, frame.size() - kHeaderBytes - kSumBytes);
  if (m.message_class != 0x01) return m;
  if (m.id == 0x07 && payload.size() == kNavPvtBytes) {
    m.body = DecodeNavPvt(payload.data());
  } else if (m.id == 0x20 && payload.size() == kNavTimeGpsBytes) {
    m.body = DecodeNavTimeGps(payload.data());
  }
  return m;
}

}  // namespace kawara::drivers
