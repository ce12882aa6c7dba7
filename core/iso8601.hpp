#pragma once
#include <string>
#include <string_view>

#include "core/expected.hpp"
#include "core/time.hpp"

namespace kawara::core {

enum class Iso8601Digits { kSeconds = 0, kMilliseconds = 3, kMicroseconds = 6, kNanoseconds = 9 };

/// "2025-07-08T19:34:18.499Z": UTC, extended format of ISO 8601 / RFC 3339. Cut, not rounded, to
/// the digits asked for, so that a stamp never lies after the instant it names and no field can
/// carry over. UtcTime cannot tell a leap second from the second after it; it prints as the latter.
std::string FormatIso8601(UtcTime t, Iso8601Digits digits = Iso8601Digits::kMilliseconds);

/// "20250708T193418Z": basic format, whole seconds; for names of files and missions.
std::string FormatIso8601Basic(UtcTime t);

/// Reads the extended format: date, 'T' (or 't' or a blank), time, optional fraction of up to 9
/// digits (more are cut), and 'Z' or an offset like "+09:00". A text without zone is refused: it
/// names no instant. Second 60 is taken only at the end of a UTC day's last minute and gives the
/// second after it. Years 1678 to 2261.
Expected<UtcTime> ParseIso8601(std::string_view text);

}  // namespace kawara::core
