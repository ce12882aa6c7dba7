#include "drivers/nmea_sentence.hpp"

#include <algorithm>
#include <array>

namespace kawara::drivers {
namespace {

enum class Kind : std::uint8_t { kText, kAddress, kStar, kBreak };

constexpr std::array<Kind, 256> MakeKinds() {
  std::array<Kind, 256> kinds{};
  for (std::size_t c = 0; c < kinds.size(); ++c) {
    const bool printable = c >= 0x20 && c < 0x7f;
    const bool address = (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    kinds[c] = !printable || c == '$' ? Kind::kBreak
               : c == '*'             ? Kind::kStar
               : address              ? Kind::kAddress
                                      : Kind::kText;
  }
  return kinds;
}
constexpr std::array<Kind, 256> kKinds = MakeKinds();

constexpr std::size_t kMinAddress = 3;
constexpr std::size_t kMaxAddress = 15;

int HexDigit(std::uint8_t c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return -1;
}

}  // namespace

std::uint8_t NmeaChecksum(std::string_view text) noexcept {
  std::uint8_t sum = 0;
  for (const char c : text) sum = static_cast<std::uint8_t>(sum ^ static_cast<std::uint8_t>(c));
  return sum;
}

NmeaProbeResult NmeaProbe(std::span<const std::uint8_t> head) noexcept {
  NmeaProbeResult result;
  if (head.empty() || head[0] != '$') return result;
  const std::size_t limit = std::min(head.size(), kNmeaMaxBytes - 3);
  std::uint8_t sum = 0;
  std::size_t at = 1;
  while (at < limit && kKinds[head[at]] == Kind::kAddress && at <= kMaxAddress)
    sum = static_cast<std::uint8_t>(sum ^ head[at++]);
  const std::size_t address_end = at;
  if (at < limit) {
    const bool ends = head[at] == ',' || head[at] == '*';
    if (!ends || at - 1 < kMinAddress || at - 1 > kMaxAddress) {
      result.length = at;
      return result;
    }
  }
  while (at < limit) {
    const Kind kind = kKinds[head[at]];
    if (kind == Kind::kStar) break;
    if (kind == Kind::kBreak) {
      result.length = at;
      return result;
    }
    sum = static_cast<std::uint8_t>(sum ^ head[at++]);
  }
  result.length = at;
  if (at == limit) {
    // Either the bytes end here, or the text is longer than any sentence.
    result.match = head.size() > limit ? NmeaMatch::kNoMatch : NmeaMatch::kNeedMore;
    return result;
  }
  const std::size_t length = at + 3;
  int claimed = 0;
  for (std::size_t i = at + 1; i < length; ++i) {
    if (i == head.size()) {
      result.match = NmeaMatch::kNeedMore;
      return result;
    }
    const int digit = HexDigit(head[i]);
    if (digit < 0) return result;
    claimed = claimed * 16 + digit;
  }
  result.length = length;
  if (claimed != sum) {
    result.match = NmeaMatch::kBadChecksum;
    return result;
  }
  result.match = NmeaMatch::kSentence;
  const auto* text = reinterpret_cast<const char*>(head.data());
  result.sentence.address = {text + 1, address_end - 1};
  result.sentence.has_fields = address_end < at;
  if (result.sentence.has_fields)
    result.sentence.fields = {text + address_end + 1, at - address_end - 1};
  return result;
}

}  // namespace kawara::drivers
