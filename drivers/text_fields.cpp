#include "drivers/text_fields.hpp"

#include <algorithm>
#include <array>

namespace kawara::drivers {
namespace {

constexpr int kMaxDecimals = 18;
constexpr std::array<double, kMaxDecimals + 1> kPowers{1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,
                                                       1e7,  1e8,  1e9,  1e10, 1e11, 1e12, 1e13,
                                                       1e14, 1e15, 1e16, 1e17, 1e18};
constexpr std::int64_t kMantissaLimit = 100'000'000'000'000'000;  // one more digit still fits

constexpr bool IsDigit(char c) { return c >= '0' && c <= '9'; }

/// Two digits at text[at], or -1.
int TwoDigits(std::string_view text, std::size_t at) {
  if (!IsDigit(text[at]) || !IsDigit(text[at + 1])) return -1;
  return (text[at] - '0') * 10 + (text[at + 1] - '0');
}

/// ".sss" (or nothing) as nanoseconds; digits beyond the ninth are dropped. -1: not that.
std::int64_t FractionNs(std::string_view text) {
  if (text.empty()) return 0;
  if (text[0] != '.') return -1;
  std::int64_t ns = 0;
  std::int64_t place = 100'000'000;
  for (const char c : text.substr(1)) {
    if (!IsDigit(c)) return -1;
    ns += (c - '0') * place;
    place /= 10;
  }
  return ns;
}

bool MakeTimeOfDay(int hour, int minute, int second, std::int64_t fraction_ns,
                   core::Duration& out) {
  if (hour < 0 || hour > 23 || minute < 0 || minute > 59 || second < 0 || fraction_ns < 0)
    return false;
  const bool leap_possible = hour == 23 && minute == 59;
  if (second > (leap_possible ? 60 : 59)) return false;
  out = core::Seconds(hour * 3600 + minute * 60 + second) + core::Nanoseconds(fraction_ns);
  return true;
}

}  // namespace

double Decimal::value() const {
  return static_cast<double>(mantissa) / kPowers[static_cast<std::size_t>(decimals)];
}

double Decimal::resolution() const { return 1.0 / kPowers[static_cast<std::size_t>(decimals)]; }

bool ParseDecimal(std::string_view text, Decimal& out) noexcept {
  const char* p = text.data();
  const char* const end = p + text.size();
  bool negative = false;
  if (p != end && (*p == '-' || *p == '+')) negative = *p++ == '-';
  std::int64_t mantissa = 0;
  int decimals = 0;
  const char* const first = p;
  for (; p != end && IsDigit(*p); ++p) {
    if (mantissa >= kMantissaLimit) return false;
    mantissa = mantissa * 10 + (*p - '0');
  }
  std::ptrdiff_t digits = p - first;
  if (p != end && *p == '.') {
    const char* const point = p++;
    for (; p != end && IsDigit(*p); ++p) {
      if (mantissa >= kMantissaLimit || decimals == kMaxDecimals) continue;
      mantissa = mantissa * 10 + (*p - '0');
      ++decimals;
    }
    digits += p - point - 1;
  }
  if (p != end || digits == 0) return false;
  out = {negative ? -mantissa : mantissa, decimals};
  return true;
}

FieldReader::FieldReader(std::string_view fields, bool has_fields) noexcept
    : rest_(fields), done_(!has_fields) {
  if (has_fields) count_ = 1 + static_cast<int>(std::count(fields.begin(), fields.end(), ','));
}

std::string_view FieldReader::Text() noexcept {
  if (done_) {
    ok_ = false;
    return {};
  }
  std::size_t n = 0;
  while (n < rest_.size() && rest_[n] != ',') ++n;
  const std::string_view field = rest_.substr(0, n);
  if (n == rest_.size()) {
    done_ = true;
    rest_ = {};
  } else {
    rest_.remove_prefix(n + 1);
  }
  return field;
}

void FieldReader::Skip(int fields) noexcept {
  for (int i = 0; i < fields; ++i) Text();
}

double FieldReader::Number(double lowest, double highest, double if_empty) noexcept {
  const std::string_view text = Text();
  if (text.empty()) return if_empty;
  Decimal number;
  if (!ParseDecimal(text, number)) {
    ok_ = false;
    return if_empty;
  }
  const double value = number.value();
  if (!(value >= lowest && value <= highest)) ok_ = false;
  return value;
}

std::int64_t FieldReader::Integer(std::int64_t lowest, std::int64_t highest,
                                  std::int64_t if_empty) noexcept {
  const std::string_view text = Text();
  if (text.empty()) return if_empty;
  Decimal number;
  if (!ParseDecimal(text, number) || number.decimals != 0 || number.mantissa < lowest ||
      number.mantissa > highest) {
    ok_ = false;
    return if_empty;
  }
  return number.mantissa;
}

char FieldReader::Letter(std::string_view allowed, bool may_be_empty) noexcept {
  const std::string_view text = Text();
  if (text.empty()) {
    if (!may_be_empty) ok_ = false;
    return '\0';
  }
  if (text.size() != 1 || allowed.find(text[0]) == std::string_view::npos) {
    ok_ = false;
    return '\0';
  }
  return text[0];
}

std::int64_t FieldReader::Hex(std::int64_t highest, std::int64_t if_empty) noexcept {
  const std::string_view text = Text();
  if (text.empty()) return if_empty;
  std::int64_t value = 0;
  for (const char c : text) {
    const int digit = IsDigit(c)               ? c - '0'
                      : (c >= 'A' && c <= 'F') ? c - 'A' + 10
                      : (c >= 'a' && c <= 'f') ? c - 'a' + 10
                                               : -1;
    value = value * 16 + digit;
    if (digit < 0 || value > highest) {
      ok_ = false;
      return if_empty;
    }
  }
  return value;
}

bool FieldReader::TimeOfDay(core::Duration& out) noexcept {
  const std::string_view text = Text();
  if (text.empty()) return false;
  if (text.size() < 6 || !MakeTimeOfDay(TwoDigits(text, 0), TwoDigits(text, 2), TwoDigits(text, 4),
                                        FractionNs(text.substr(6)), out)) {
    ok_ = false;
    return false;
  }
  return true;
}

bool FieldReader::TimeOfDayWithColons(core::Duration& out) noexcept {
  const std::string_view text = Text();
  if (text.empty()) return false;
  if (text.size() < 8 || text[2] != ':' || text[5] != ':' ||
      !MakeTimeOfDay(TwoDigits(text, 0), TwoDigits(text, 3), TwoDigits(text, 6),
                     FractionNs(text.substr(8)), out)) {
    ok_ = false;
    return false;
  }
  return true;
}

/// [d]ddmm.mmm and its hemisphere. All in integers until the one division, which is correctly
/// rounded.
double FieldReader::Angle(int max_degrees, char negative, char positive, bool& given) noexcept {
  const std::string_view text = Text();
  const std::string_view side = Text();
  given = !text.empty();
  if (!given) {
    // A hemisphere without a number is what some receivers send before the first fix.
    if (side.size() > 1) ok_ = false;
    return kNotSaid;
  }
  Decimal number;
  if (side.size() != 1 || (side[0] != negative && side[0] != positive) || !IsDigit(text[0]) ||
      !ParseDecimal(text, number) || number.decimals > 14) {
    ok_ = false;
    return kNotSaid;
  }
  std::int64_t unit = 1;
  for (int i = 0; i < number.decimals; ++i) unit *= 10;
  const std::int64_t degrees = number.mantissa / (100 * unit);
  const std::int64_t minutes = number.mantissa % (100 * unit);
  // 60.000 minutes is what rounding makes of 59.9999 in some receivers.
  if (minutes > 60 * unit || degrees > max_degrees) {
    ok_ = false;
    return kNotSaid;
  }
  const std::int64_t numerator = degrees * 60 * unit + minutes;
  if (numerator > max_degrees * (60 * unit)) {
    ok_ = false;
    return kNotSaid;
  }
  const double angle = static_cast<double>(numerator) / static_cast<double>(60 * unit);
  return side[0] == negative ? -angle : angle;
}

bool FieldReader::LatLon(double& lat_deg, double& lon_deg) noexcept {
  bool has_lat = false;
  bool has_lon = false;
  const double lat = Angle(90, 'S', 'N', has_lat);
  const double lon = Angle(180, 'W', 'E', has_lon);
  if (has_lat != has_lon) ok_ = false;
  if (!ok_ || !has_lat) return false;
  lat_deg = lat;
  lon_deg = lon;
  return true;
}

}  // namespace kawara::drivers
