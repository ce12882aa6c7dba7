#include "drivers/ashtech_binary.hpp"

#include <bit>
#include <cmath>
#include <cstring>

namespace kawara::drivers {
namespace {

constexpr std::string_view kPrefix = "$PASHR,";
constexpr std::size_t kHeaderBytes = 11;  // "$PASHR,PBN,"

enum class Sum : std::uint8_t { kWords16, kXor8 };
struct RecordType {
  std::string_view name;
  std::size_t structure_bytes;  ///< checksum included
  Sum sum;
};
// MCA and MPC: a header of 7 bytes, one or three blocks of 29, and the XOR of those.
constexpr std::array<RecordType, 3> kRecordTypes{
    {{"PBN", 56, Sum::kWords16}, {"MCA", 37, Sum::kXor8}, {"MPC", 95, Sum::kXor8}}};

std::uint32_t Big(const std::uint8_t* p, std::size_t bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) value = value << 8 | p[i];
  return value;
}

double BigDouble(const std::uint8_t* p) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(Big(p, 4)) << 32 | Big(p + 4, 4));
}

double BigFloat(const std::uint8_t* p) {
  return static_cast<double>(std::bit_cast<float>(Big(p, 4)));
}

bool GoodSum(Sum kind, std::span<const std::uint8_t> s) {
  if (kind == Sum::kXor8) {
    std::uint8_t sum = 0;
    for (const std::uint8_t b : s) sum = static_cast<std::uint8_t>(sum ^ b);
    return sum == 0;
  }
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i + 2 < s.size(); i += 2) sum += Big(s.data() + i, 2);
  return (sum & 0xFFFFU) == Big(s.data() + s.size() - 2, 2);
}

/// The ASCII form of the same type begins with digits and commas; a whole header of printable bytes
/// is text.
bool LooksLikeText(std::span<const std::uint8_t> s) {
  for (const std::uint8_t b : s) {
    if (b < 0x20 || b > 0x7e) return b == '\r' || b == '\n';
  }
  return true;
}

}  // namespace

AshtechBinaryProbeResult AshtechBinaryProbe(std::span<const std::uint8_t> head) noexcept {
  AshtechBinaryProbeResult result;
  const std::size_t prefix = std::min(head.size(), kPrefix.size());
  if (head.empty() || std::memcmp(head.data(), kPrefix.data(), prefix) != 0) return result;
  if (head.size() < kHeaderBytes) {
    result.match = AshtechBinaryMatch::kNeedMore;
    result.length = kHeaderBytes;
    return result;
  }
  const std::string_view name(reinterpret_cast<const char*>(head.data()) + kPrefix.size(), 3);
  for (const RecordType& type : kRecordTypes) {
    if (name != type.name || head[kHeaderBytes - 1] != ',') continue;
    result.length = kHeaderBytes + type.structure_bytes;
    name.copy(result.type.data(), result.type.size());
    if (head.size() < result.length) {
      result.match = AshtechBinaryMatch::kNeedMore;
      return result;
    }
    result.structure = head.subspan(kHeaderBytes, type.structure_bytes);
    if (GoodSum(type.sum, result.structure)) {
      result.match = AshtechBinaryMatch::kRecord;
    } else {
      result.match = LooksLikeText(result.structure) ? AshtechBinaryMatch::kNoMatch
                                                     : AshtechBinaryMatch::kBadChecksum;
    }
    return result;
  }
  return result;
}

AshtechPbn DecodePbn(std::span<const std::uint8_t> structure) noexcept {
  AshtechPbn m;
  if (structure.size() < 56) return m;
  const std::uint8_t* p = structure.data();
  const auto milliseconds = static_cast<std::int32_t>(Big(p, 4));
  m.time_of_week = core::Milliseconds(milliseconds);
  std::memcpy(m.site.data(), p + 4, m.site.size());
  m.ecef_m = {BigDouble(p + 8), BigDouble(p + 16), BigDouble(p + 24)};
  m.clock_offset_m = BigFloat(p + 32);
  m.velocity_ecef_mps = {BigFloat(p + 36), BigFloat(p + 40), BigFloat(p + 44)};
  m.clock_drift_mps = BigFloat(p + 48);
  m.pdop = 0.01 * Big(p + 52, 2);
  const double radius_m = m.ecef_m.norm();
  m.plausible = milliseconds >= 0 && m.time_of_week < core::kGpsWeek && radius_m > 6.3e6 &&
                radius_m < 7.0e6 && m.velocity_ecef_mps.norm() < 1000.0;
  return m;
}

}  // namespace kawara::drivers
