#include "core/iso8601.hpp"

#include <array>
#include <cstdio>
#include <optional>

namespace kawara::core {
namespace {

/// Takes fixed-width fields off the front of a text.
class Cursor {
 public:
  explicit Cursor(std::string_view text) : rest_(text) {}

  bool AtEnd() const { return rest_.empty(); }
  char Peek() const { return rest_.empty() ? '\0' : rest_.front(); }
  bool Take(char c) {
    if (Peek() != c) return false;
    rest_.remove_prefix(1);
    return true;
  }
  bool IsDigit() const { return Peek() >= '0' && Peek() <= '9'; }
  int TakeDigit() {
    const int digit = rest_.front() - '0';
    rest_.remove_prefix(1);
    return digit;
  }
  /// Exactly this many digits.
  std::optional<int> Number(int digits) {
    int value = 0;
    for (int i = 0; i < digits; ++i) {
      if (!IsDigit()) return std::nullopt;
      value = value * 10 + TakeDigit();
    }
    return value;
  }

 private:
  std::string_view rest_;
};

bool TakeDate(Cursor& in, CivilTime& c) {
  const auto year = in.Number(4);
  if (!year || !in.Take('-')) return false;
  const auto month = in.Number(2);
  if (!month || !in.Take('-')) return false;
  const auto day = in.Number(2);
  if (!day) return false;
  c.year = *year;
  c.month = *month;
  c.day = *day;
  return true;
}

bool TakeTime(Cursor& in, CivilTime& c) {
  const auto hour = in.Number(2);
  if (!hour || !in.Take(':')) return false;
  const auto minute = in.Number(2);
  if (!minute || !in.Take(':')) return false;
  const auto second = in.Number(2);
  if (!second) return false;
  c.hour = *hour;
  c.minute = *minute;
  c.second = *second;
  if (!in.Take('.') && !in.Take(',')) return true;
  if (!in.IsDigit()) return false;
  std::int32_t unit = 100'000'000;
  while (in.IsDigit()) {
    c.nanosecond += in.TakeDigit() * unit;
    unit /= 10;
  }
  return true;
}

/// Offset from UTC.
std::optional<Duration> TakeZone(Cursor& in) {
  if (in.Take('Z') || in.Take('z')) return Duration(0);
  const bool west = in.Peek() == '-';
  if (!in.Take('+') && !in.Take('-')) return std::nullopt;
  const auto hours = in.Number(2);
  in.Take(':');
  const auto minutes = in.Number(2);
  if (!hours || !minutes || *hours > 23 || *minutes > 59) return std::nullopt;
  const Duration offset = std::chrono::hours(*hours) + std::chrono::minutes(*minutes);
  return west ? -offset : offset;
}

}  // namespace

std::string FormatIso8601(UtcTime t, Iso8601Digits digits) {
  const CivilTime c = ToCivil(t);
  std::array<char, 48> text;
  int n = std::snprintf(text.data(), text.size(), "%04d-%02d-%02dT%02d:%02d:%02d.%09d", c.year,
                        c.month, c.day, c.hour, c.minute, c.second, c.nanosecond);
  n -= digits == Iso8601Digits::kSeconds ? 10 : 9 - static_cast<int>(digits);
  return std::string(text.data(), static_cast<std::size_t>(n)) + "Z";
}

std::string FormatIso8601Basic(UtcTime t) {
  const CivilTime c = ToCivil(t);
  std::array<char, 48> text;
  const int n = std::snprintf(text.data(), text.size(), "%04d%02d%02dT%02d%02d%02dZ", c.year,
                              c.month, c.day, c.hour, c.minute, c.second);
  return std::string(text.data(), static_cast<std::size_t>(n));
}

Expected<UtcTime> ParseIso8601(std::string_view text) {
  const auto refuse = [&](const char* why) {
    return Fail(ErrorCode::kFormat, "\"" + std::string(text.substr(0, 40)) + "\": " + why +
                                        ": expected a time like 2025-07-08T19:34:18.499Z");
  };
  Cursor in(text);
  CivilTime c;
  if (!TakeDate(in, c)) return refuse("no date");
  if (!in.Take('T') && !in.Take('t') && !in.Take(' ')) return refuse("no T after the date");
  if (!TakeTime(in, c)) return refuse("no time");
  const auto offset = TakeZone(in);
  if (!offset) return refuse("no zone (Z or +hh:mm)");
  if (!in.AtEnd()) return refuse("more behind it");
  CivilTime without_leap = c;  // 23:59:60 UTC is another time of day in other zones
  if (c.second == 60) without_leap.second = 59;
  if (!IsValid(without_leap)) return refuse("no such date or time");
  const UtcTime t = FromCivil(c) - *offset;
  // After adding the 60th second a true leap second stands at 00:00:00 of a UTC day.
  if (c.second == 60 && (t - Nanoseconds(c.nanosecond)).ns() % kDay.count() != 0) {
    return refuse("second 60 but not at the end of a UTC day");
  }
  return t;
}

}  // namespace kawara::core
