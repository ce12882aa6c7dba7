#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kawara::survey {

// The text of a table of anyone's: lines of fields. Views are into what was given. Any thread.

/// Without spaces, tabs and returns at its ends.
std::string_view Trimmed(std::string_view text);

/// What parts a table's fields, by its first line: ',', ' ' (any white space), or ';', which
/// spreadsheets write where numbers have a decimal comma.
char SeparatorOf(std::string_view header);

/// A line's fields, trimmed. One in quotes may have separators in it (RFC 4180) and comes without
/// the quotes; quotes within it stay doubled.
std::vector<std::string_view> Fields(std::string_view line, char separator);

/// Nothing, or "nan": what loggers write when they know nothing.
bool IsUnknown(std::string_view field);

/// A finite decimal number, with or without sign, and nothing else.
std::optional<double> Number(std::string_view text);

std::optional<std::int64_t> Integer(std::string_view text);

/// Decimal seconds to nanoseconds without a double's rounding (1700000000.123456789 has 19 digits).
std::optional<std::int64_t> NanosecondsOf(std::string_view text);

}  // namespace kawara::survey
