#include "tools/json_lines.hpp"

#include <array>
#include <charconv>
#include <cmath>

namespace kawara::tools {
namespace {

template <class T>
void AppendInteger(std::string& out, T value) {
  std::array<char, 24> digits{};
  const auto result = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  out.append(digits.data(), result.ptr);
}

/// Bytes of the UTF-8 character of two to four bytes that `text` begins with, 0 if it is none.
std::size_t Utf8Length(std::string_view text) {
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const std::size_t n = at(0) >= 0xF0 ? 4 : at(0) >= 0xE0 ? 3 : 2;
  if (at(0) < 0xC2 || at(0) > 0xF4 || text.size() < n) return 0;
  for (std::size_t i = 1; i < n; ++i) {
    if ((at(i) & 0xC0U) != 0x80U) return 0;
  }
  // Too long for what it says, a surrogate, or beyond the last code point.
  const unsigned first_two = static_cast<unsigned>(at(0)) << 8 | at(1);
  const bool wrong = (first_two >= 0xE080 && first_two < 0xE0A0) ||
                     (first_two >= 0xEDA0 && first_two < 0xEDC0) ||
                     (first_two >= 0xF080 && first_two < 0xF090) || first_two >= 0xF490;
  return wrong ? 0 : n;
}

}  // namespace

void JsonLines::Begin(std::string_view type) {
  BeginBare();
  Text("type", type);
}

void JsonLines::BeginBare() {
  line_.assign(1, '{');
  first_ = true;
}

void JsonLines::End() {
  line_ += "}\n";
  if (std::fwrite(line_.data(), 1, line_.size(), stream_) != line_.size()) ok_ = false;
}

bool JsonLines::Flush() {
  if (std::fflush(stream_) != 0) ok_ = false;
  return ok_;
}

void JsonLines::Number(std::string_view key, double value, int decimals) {
  if (!std::isfinite(value)) return Null(key);
  Key(key);
  std::array<char, 400> digits{};
  const auto result = std::to_chars(digits.data(), digits.data() + digits.size(), value,
                                    std::chars_format::fixed, decimals);
  std::string_view text(digits.data(), static_cast<std::size_t>(result.ptr - digits.data()));
  if (text.find('.') != std::string_view::npos) {
    while (text.back() == '0') text.remove_suffix(1);
    if (text.back() == '.') text.remove_suffix(1);
  }
  line_ += text == "-0" ? "0" : text;
}

void JsonLines::Integer(std::string_view key, std::int64_t value) {
  Key(key);
  AppendInteger(line_, value);
}

void JsonLines::Unsigned(std::string_view key, std::uint64_t value) {
  Key(key);
  AppendInteger(line_, value);
}

void JsonLines::Boolean(std::string_view key, bool value) {
  Key(key);
  line_ += value ? "true" : "false";
}

void JsonLines::Text(std::string_view key, std::string_view value) {
  Key(key);
  Quoted(value);
}

void JsonLines::Null(std::string_view key) {
  Key(key);
  line_ += "null";
}

void JsonLines::OpenObject(std::string_view key) {
  Key(key);
  line_ += '{';
  first_ = true;
}

void JsonLines::CloseObject() {
  line_ += '}';
  first_ = false;
}

void JsonLines::OpenArray(std::string_view key) {
  Key(key);
  line_ += '[';
  first_ = true;
}

void JsonLines::CloseArray() {
  line_ += ']';
  first_ = false;
}

void JsonLines::Key(std::string_view key) {
  if (!first_) line_ += ',';
  first_ = false;
  if (key.empty()) return;
  Quoted(key);
  line_ += ':';
}

void JsonLines::Quoted(std::string_view text) {
  constexpr std::string_view kHex = "0123456789abcdef";
  line_ += '"';
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const std::size_t sequence = byte < 0x80 ? 0 : Utf8Length(text.substr(i));
    if (byte == '"' || byte == '\\') {
      line_ += '\\';
      line_ += text[i];
    } else if (sequence > 0) {
      line_ += text.substr(i, sequence);
      i += sequence - 1;
    } else if (byte < 0x20 || byte > 0x7e) {
      line_ += "\\u00";
      line_ += kHex[byte >> 4];
      line_ += kHex[byte & 15U];
    } else {
      line_ += text[i];
    }
  }
  line_ += '"';
}

}  // namespace kawara::tools
