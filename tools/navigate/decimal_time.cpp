#include "tools/navigate/decimal_time.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

namespace kawara::navigate {
namespace {

constexpr std::int64_t kMaxSeconds = 4'000'000'000;
constexpr std::int64_t kNsInSecond = 1'000'000'000;

/// Second 0 of the files. Any week would do; not the epoch itself, because a time of 0 ns means
/// "not set" there.
constexpr core::GpsTime kZero = core::GpsTime::FromNs(2300 * core::kGpsWeek.count());

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

std::optional<core::GpsTime> ParseSeconds(std::string_view text) {
  if (text.find_first_of("eE") != std::string_view::npos) {
    // No program prints times like that; when one does, a double is what it had.
    double seconds = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    if (!(std::abs(seconds) <= static_cast<double>(kMaxSeconds))) return std::nullopt;
    return kZero + core::Nanoseconds(std::llround(seconds * 1e9));
  }
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  std::int64_t seconds = 0;
  std::size_t i = 0;
  for (; i < text.size() && IsDigit(text[i]); ++i) {
    seconds = 10 * seconds + (text[i] - '0');
    if (seconds > kMaxSeconds) return std::nullopt;
  }
  std::size_t digits = i;
  std::int64_t ns = 0;
  if (i < text.size() && text[i] == '.') {
    std::int64_t weight = kNsInSecond / 10;
    bool next_is_first_beyond = true;
    for (++i; i < text.size() && IsDigit(text[i]); ++i, ++digits) {
      if (weight > 0) {
        ns += weight * (text[i] - '0');
        weight /= 10;
      } else if (next_is_first_beyond) {
        if (text[i] >= '5') ++ns;
        next_is_first_beyond = false;
      }
    }
  }
  if (i != text.size() || digits == 0) return std::nullopt;
  const std::int64_t all = seconds * kNsInSecond + ns;
  return kZero + core::Nanoseconds(negative ? -all : all);
}

std::string FormatSeconds(core::GpsTime t) {
  const std::int64_t all = (t - kZero).count();
  const std::int64_t size = std::llabs(all);
  std::array<char, 40> text{};
  const int length = std::snprintf(text.data(), text.size(), "%s%lld.%09lld", all < 0 ? "-" : "",
                                   static_cast<long long>(size / kNsInSecond),
                                   static_cast<long long>(size % kNsInSecond));
  std::string out(text.data(), static_cast<std::size_t>(length));
  constexpr std::size_t kMaySpare = 6;  // of nine digits
  std::size_t spared = 0;
  while (spared < kMaySpare && out.back() == '0') {
    out.pop_back();
    ++spared;
  }
  return out;
}

double SecondsOf(core::GpsTime t) { return core::ToSeconds(t - kZero); }

}  // namespace kawara::navigate
