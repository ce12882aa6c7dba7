#include "core/config/scalars.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "core/check.hpp"

namespace kawara::core::config {
namespace {

void Report(const Node& node, const std::string& path, const std::string& expected,
            Problems& problems) {
  problems.Add(node.place, path + " = " + node.Shown() + ": expected " + expected);
}

bool IsPlain(const Node& node) { return node.kind == Node::Kind::kScalar && !node.quoted; }

std::string_view WithoutPlus(std::string_view text) {
  return text.size() > 1 && text[0] == '+' && text[1] != '-' ? text.substr(1) : text;
}

/// nullopt: not a whole number. Saturates beyond 64 bits, so that "out of range" is what gets
/// reported.
std::optional<std::int64_t> ParseInteger(std::string_view text) {
  text = WithoutPlus(text);
  const bool negative = text.starts_with('-');
  if (negative) text.remove_prefix(1);
  int base = 10;
  if (text.starts_with("0x") || text.starts_with("0X")) {
    base = 16;
    text.remove_prefix(2);
  }
  if (text.empty() || text.front() == '-') return std::nullopt;
  std::uint64_t magnitude = 0;
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), magnitude, base);
  if (end != text.data() + text.size() || error == std::errc::invalid_argument) return std::nullopt;
  constexpr std::uint64_t kMax = std::numeric_limits<std::int64_t>::max();
  if (error == std::errc::result_out_of_range || magnitude > kMax) magnitude = kMax;
  const auto value = static_cast<std::int64_t>(magnitude);
  return negative ? -value : value;
}

std::optional<double> ParseDouble(std::string_view text) {
  text = WithoutPlus(text);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size() ||
      !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

std::string ShortNumber(double value) {
  std::array<char, 40> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  return std::string(digits.data(), end);
}

/// The constraints alone, "20..20000" or "one of 1, 2"; empty if there are none.
std::string Bounds(const Constraints& c) {
  if (c.one_of) {
    std::string all = "one of ";
    for (const std::string& text : c.one_of->texts)
      all += (&text == c.one_of->texts.data() ? "" : ", ") + text;
    for (const double& number : c.one_of->numbers) {
      all += (&number == c.one_of->numbers.data() ? "" : ", ") + ShortNumber(number);
    }
    return all;
  }
  return c.range ? ShortNumber(c.range->min) + ".." + ShortNumber(c.range->max) : "";
}

std::string WithBounds(const std::string& what, const Constraints& c) {
  const std::string bounds = Bounds(c);
  return bounds.empty() ? what : what + (c.one_of ? ", " : " ") + bounds;
}

bool Fits(double value, const Constraints& c) {
  if (c.range && !(value >= c.range->min && value <= c.range->max)) return false;
  if (c.one_of && !c.one_of->numbers.empty()) {
    return std::find(c.one_of->numbers.begin(), c.one_of->numbers.end(), value) !=
           c.one_of->numbers.end();
  }
  return true;
}

std::string_view LastKey(const std::string& path) {
  std::string_view key = path;
  key = key.substr(key.rfind('.') + 1);  // npos + 1 is 0
  return key.substr(0, key.find('['));
}

struct Unit {
  const char* suffix;
  const char* name;
  std::int64_t ns;
};
constexpr std::array<Unit, 6> kUnits{{{"_ns", "nanoseconds", 1},
                                      {"_us", "microseconds", 1000},
                                      {"_ms", "milliseconds", 1000000},
                                      {"_s", "seconds", 1000000000},
                                      {"_min", "minutes", 60000000000},
                                      {"_h", "hours", 3600000000000}}};

const Unit& UnitOf(const std::string& path) {
  const std::string_view key = LastKey(path);
  const auto unit = std::find_if(kUnits.begin(), kUnits.end(),
                                 [&](const Unit& u) { return key.ends_with(u.suffix); });
  CORE_CHECK(unit != kUnits.end());
  return *unit;
}

}  // namespace

void ReadBool(const Node& node, const std::string& path, bool& out, Problems& problems) {
  if (IsPlain(node) && (node.text == "true" || node.text == "false")) {
    out = node.text == "true";
  } else {
    Report(node, path, ExpectedBool(), problems);
  }
}

void ReadInteger(const Node& node, const std::string& path, const Constraints& constraints,
                 std::int64_t min, std::int64_t max, std::int64_t& out, Problems& problems) {
  const auto value = IsPlain(node) ? ParseInteger(node.text) : std::nullopt;
  if (!value) return Report(node, path, ExpectedInteger(constraints, min, max), problems);
  if (!Fits(static_cast<double>(*value), constraints)) {
    return Report(node, path, Bounds(constraints), problems);
  }
  if (*value < min || *value > max) {
    return Report(node, path, std::to_string(min) + ".." + std::to_string(max), problems);
  }
  out = *value;
}

void ReadDouble(const Node& node, const std::string& path, const Constraints& constraints,
                double& out, Problems& problems) {
  const auto value = IsPlain(node) ? ParseDouble(node.text) : std::nullopt;
  if (!value) return Report(node, path, ExpectedDouble(constraints), problems);
  if (!Fits(*value, constraints)) return Report(node, path, Bounds(constraints), problems);
  out = *value;
}

void ReadString(const Node& node, const std::string& path, const Constraints& constraints,
                std::string& out, Problems& problems) {
  if (node.kind != Node::Kind::kScalar || (constraints.not_empty && node.text.empty())) {
    return Report(node, path, ExpectedString(constraints), problems);
  }
  if (constraints.one_of) {
    const auto& allowed = constraints.one_of->texts;
    if (std::find(allowed.begin(), allowed.end(), node.text) == allowed.end()) {
      return Report(node, path, Bounds(constraints), problems);
    }
  }
  out = node.text;
}

void ReadNamedTexts(const Node& node, const std::string& path, NamedTexts& out,
                    Problems& problems) {
  if (node.kind != Node::Kind::kMap) return Report(node, path, ExpectedNamedTexts(), problems);
  out.clear();
  for (std::size_t i = 0; i < node.keys.size(); ++i) {
    const Node& value = node.items[i];
    if (value.kind != Node::Kind::kScalar) {
      Report(value, path + "." + node.keys[i].text, "a single value", problems);
    } else {
      out.emplace_back(node.keys[i].text, value.text);
    }
  }
}

void ReadDuration(const Node& node, const std::string& path, const Constraints& constraints,
                  Duration& out, Problems& problems) {
  const auto value = IsPlain(node) ? ParseDouble(node.text) : std::nullopt;
  if (!value) return Report(node, path, ExpectedDuration(path, constraints), problems);
  if (!Fits(*value, constraints)) return Report(node, path, Bounds(constraints), problems);
  const double per_unit = static_cast<double>(NanosecondsPerUnit(path));
  const double ns = *value * per_unit;
  if (!(std::abs(ns) <= 9e18)) {
    const std::string limit = ShortNumber(std::floor(9e18 / per_unit));
    return Report(node, path, "-" + limit + ".." + limit, problems);
  }
  out = Duration(std::llround(ns));
}

void ReadEnum(const Node& node, const std::string& path, const std::vector<const char*>& names,
              std::size_t& out, Problems& problems) {
  if (node.kind == Node::Kind::kScalar) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (node.text == names[i]) {
        out = i;
        return;
      }
    }
  }
  Report(node, path, ExpectedEnum(names), problems);
}

std::string ExpectedBool() { return "true or false"; }
std::string ExpectedInteger(const Constraints& constraints, std::int64_t min, std::int64_t max) {
  if (Bounds(constraints).empty() && max != std::numeric_limits<std::int64_t>::max()) {
    return "a whole number " + std::to_string(min) + ".." + std::to_string(max);
  }
  return WithBounds("a whole number", constraints);
}
std::string ExpectedDouble(const Constraints& constraints) {
  return WithBounds("a number", constraints);
}
std::string ExpectedString(const Constraints& constraints) {
  return WithBounds(constraints.not_empty ? "text (not empty)" : "text", constraints);
}
std::string ExpectedNamedTexts() { return "a section {name: value, ...}"; }

std::string ExpectedDuration(const std::string& path, const Constraints& constraints) {
  return WithBounds(std::string("a number of ") + UnitOf(path).name, constraints);
}
std::string ExpectedEnum(const std::vector<const char*>& names) {
  return "one of " + JoinNames(names);
}

std::string TextOfDouble(double value) {
  std::string text = ShortNumber(value);
  if (text.find_first_not_of("-0123456789") == std::string::npos) text += ".0";
  return text;
}

std::string TextOfString(const std::string& value) {
  constexpr std::string_view kHex = "0123456789abcdef";
  std::string text = "\"";
  for (const char c : value) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      text += '\\';
      text += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      text += "\\x";
      text += kHex[byte >> 4];
      text += kHex[byte & 15];
    } else {
      text += c;
    }
  }
  return text + '"';
}

std::string TextOfDuration(Duration value, const std::string& path) {
  const std::int64_t unit = NanosecondsPerUnit(path);
  if (value.count() % unit == 0) return std::to_string(value.count() / unit);
  return TextOfDouble(static_cast<double>(value.count()) / static_cast<double>(unit));
}

std::int64_t NanosecondsPerUnit(const std::string& path) { return UnitOf(path).ns; }

}  // namespace kawara::core::config
