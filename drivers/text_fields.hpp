#pragma once
#include <cstdint>
#include <limits>
#include <string_view>

#include "core/time.hpp"

/// Reading of comma-separated fields. Numbers are read as integers and scaled once, so that every
/// printed digit survives (0.01 um of latitude in a double) and no locale has a say. Nothing here
/// allocates or throws.
namespace kawara::drivers {

constexpr double kNotSaid = std::numeric_limits<double>::quiet_NaN();

/// A decimal number as printed: value = mantissa / 10^decimals.
struct Decimal {
  std::int64_t mantissa = 0;
  int decimals = 0;
  double value() const;       ///< correctly rounded below 2^53
  double resolution() const;  ///< 10^-decimals
};
/// Optional sign, digits, optional point and digits; at least one digit. Digits after the 18th
/// significant one are dropped. False for anything else, exponents included.
bool ParseDecimal(std::string_view text, Decimal& out) noexcept;

/// Walks over the fields of a sentence, left to right. Every reader takes one field; the first one
/// that is not what it should be makes ok() false for good, and readers go on giving "not said", so
/// that a parser is a plain list of readings with one check at its end.
class FieldReader {
 public:
  explicit FieldReader(std::string_view fields, bool has_fields = true) noexcept;

  bool ok() const { return ok_; }
  bool done() const { return done_; }   ///< no field left
  int count() const { return count_; }  ///< fields in the sentence

  std::string_view Text() noexcept;
  void Skip(int fields = 1) noexcept;
  /// Empty is `if_empty`. Not a number or outside [lowest, highest]: fails.
  double Number(double lowest, double highest, double if_empty = kNotSaid) noexcept;
  std::int64_t Integer(std::int64_t lowest, std::int64_t highest, std::int64_t if_empty) noexcept;
  /// One of the characters of `allowed`; empty gives '\0' if `may_be_empty`.
  char Letter(std::string_view allowed, bool may_be_empty = true) noexcept;
  /// Hexadecimal digits.
  std::int64_t Hex(std::int64_t highest, std::int64_t if_empty) noexcept;
  /// hhmmss[.s...] as time of day; 23:59:60 is 86400 s and more. False: empty.
  bool TimeOfDay(core::Duration& out) noexcept;
  /// hh:mm:ss[.s...]
  bool TimeOfDayWithColons(core::Duration& out) noexcept;
  /// ddmm.mmm,N,dddmm.mmm,E: four fields, degrees. False: all empty.
  bool LatLon(double& lat_deg, double& lon_deg) noexcept;
  void Fail() noexcept { ok_ = false; }

 private:
  double Angle(int max_degrees, char negative, char positive, bool& given) noexcept;

  std::string_view rest_;
  int count_ = 0;
  bool done_ = false;
  bool ok_ = true;
};

}  // namespace kawara::drivers
