#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "core/time.hpp"

/// Seconds written as decimal text, to and from core::GpsTime without losing a digit. The files
/// count GPS seconds of the week, or seconds of anything, and do not say which week: they all land
/// in the same arbitrary one, and leave it as they came.
namespace kawara::navigate {

/// "300000.01333" (sign, digits, point, exponent as in "1.5e3"); digits beyond the nanosecond are
/// rounded. Nothing if that is no number or beyond +-4e9 s (so Unix seconds are welcome).
std::optional<core::GpsTime> ParseSeconds(std::string_view text);

/// The same seconds again, with three digits behind the point, or as many up to nine as it takes.
std::string FormatSeconds(core::GpsTime t);

/// As a number, for tables and pictures.
double SecondsOf(core::GpsTime t);

}  // namespace kawara::navigate
