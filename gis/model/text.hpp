#pragma once
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string>

#include "core/geodesy.hpp"

namespace kawara::gis {

/// Appends a number with a fixed number of decimals, whatever the locale, without useless zeros.
inline void AppendNumber(std::string& text, double value, int decimals) {
  std::array<char, 400> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                 std::chars_format::fixed, decimals);
  std::string_view digits(buffer.data(), static_cast<std::size_t>(end.ptr - buffer.data()));
  if (digits.find('.') != std::string_view::npos) {
    while (digits.ends_with('0')) digits.remove_suffix(1);
    if (digits.ends_with('.')) digits.remove_suffix(1);
  }
  text += digits == "-0" ? std::string_view("0") : digits;
}

inline std::string Number(double value, int decimals) {
  std::string text;
  AppendNumber(text, value, decimals);
  return text;
}

/// "WGS 84 latitude 35.12345678 deg, longitude ..., ellipsoidal height ... m".
inline std::string OriginText(const core::Geodetic& origin) {
  return "WGS 84 latitude " + Number(origin.lat_rad * core::kDegFromRad, 10) + " deg, longitude " +
         Number(origin.lon_rad * core::kDegFromRad, 10) + " deg, ellipsoidal height " +
         Number(origin.h_ellipsoidal_m, 4) + " m";
}

/// Appends a value's own bytes (little-endian machines only).
template <class T>
void AppendBytes(std::string& bytes, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  std::array<char, sizeof(T)> raw{};
  std::memcpy(raw.data(), &value, sizeof(T));
  bytes.append(raw.data(), raw.size());
}

}  // namespace kawara::gis
