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
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      line_ += '\\';
      line_ += c;
    } else if (byte < 0x20 || byte > 0x7e) {
      line_ += "\\u00";
      line_ += kHex[byte >> 4];
      line_ += kHex[byte & 15U];
    } else {
      line_ += c;
    }
  }
  line_ += '"';
}

}  // namespace kawara::tools
