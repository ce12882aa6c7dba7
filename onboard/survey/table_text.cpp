#include "onboard/survey/table_text.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace kawara::survey {
namespace {

/// A field without the quotes around it.
std::string_view Unquoted(std::string_view field) {
  field = Trimmed(field);
  if (field.size() < 2 || field.front() != '"' || field.back() != '"') return field;
  return Trimmed(field.substr(1, field.size() - 2));
}

/// Where the line's first field ends; a separator in quotes is none. Source: RFC 4180.
std::size_t EndOfField(std::string_view line, char separator) {
  const std::size_t first = line.find_first_not_of(" \t");
  if (first == std::string_view::npos || line[first] != '"') return line.find(separator);
  bool quoted = false;
  for (std::size_t i = first; i < line.size(); ++i) {
    if (line[i] == '"') quoted = !quoted;
    if (line[i] == separator && !quoted) return i;
  }
  return std::string_view::npos;
}

}  // namespace

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r";
  const std::size_t first = text.find_first_not_of(kSpace);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

std::vector<std::string_view> Fields(std::string_view line, char separator) {
  std::vector<std::string_view> fields;
  while (true) {
    if (separator == ' ') line = Trimmed(line);
    const std::size_t end =
        separator == ' ' ? line.find_first_of(" \t") : EndOfField(line, separator);
    fields.push_back(Unquoted(line.substr(0, end)));
    if (end == std::string_view::npos) return fields;
    line.remove_prefix(end + 1);
  }
}

char SeparatorOf(std::string_view header) {
  if (header.find(';') != std::string_view::npos) return ';';
  return header.find(',') != std::string_view::npos ? ',' : ' ';
}

bool IsUnknown(std::string_view field) {
  const auto same = [](char a, char b) { return (a | 0x20) == b; };
  constexpr std::string_view kNan = "nan";
  return field.empty() || std::ranges::equal(field, kNan, same);
}

std::optional<double> Number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

std::optional<std::int64_t> Integer(std::string_view text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return {};
  return value;
}

std::optional<std::int64_t> NanosecondsOf(std::string_view text) {
  const std::size_t point = text.find('.');
  if (text.find_first_not_of("0123456789.-") != std::string_view::npos) {
    const auto seconds = Number(text);
    if (!seconds || std::abs(*seconds) > 9e9) return {};
    return std::llround(*seconds * 1e9);
  }
  const auto whole = Integer(text.substr(0, point));
  if (!whole || *whole > 9'000'000'000 || *whole < -9'000'000'000) return {};
  std::string digits(point == std::string_view::npos ? "" : text.substr(point + 1));
  if (digits.find_first_not_of("0123456789") != std::string::npos) return {};
  digits.resize(9, '0');
  const std::int64_t fraction = *Integer(digits);
  return *whole * 1'000'000'000 + (text.starts_with('-') ? -fraction : fraction);
}

}  // namespace kawara::survey
