#pragma once
#include <algorithm>
#include <array>
#include <charconv>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <string_view>

namespace kawara::core {

/// Text of at most N bytes in place, cut where it would run over. Real-time safe: no allocation, no
/// locale.
///     FixedText<200> text("no fix for ");
///     text.Append(12.34, 1).Append(" s");
template <std::size_t N>
class FixedText {
 public:
  constexpr FixedText() = default;
  FixedText(std::string_view text) { Append(text); }  // NOLINT(google-explicit-constructor)
  FixedText(const char* text) { Append(text); }       // NOLINT(google-explicit-constructor)

  FixedText& Append(std::string_view text) {
    if (text.data() == nullptr) return *this;  // an empty view's, which memcpy must not be given
    const std::size_t n = std::min(text.size(), N - size_);
    std::memcpy(chars_.data() + size_, text.data(), n);
    size_ += n;
    return *this;
  }
  FixedText& Append(const char* text) { return Append(std::string_view(text)); }
  template <std::integral Int>
  FixedText& Append(Int value) {
    std::array<char, 24> digits;
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    return Append(std::string_view(digits.data(), static_cast<std::size_t>(end - digits.data())));
  }
  /// With this many digits after the point (0..9); the shortest form where that would be longer
  /// than 32 bytes.
  FixedText& Append(double value, int decimals) {
    std::array<char, 32> digits;
    char* const begin = digits.data();
    char* const limit = begin + digits.size();
    auto result =
        std::to_chars(begin, limit, value, std::chars_format::fixed, std::clamp(decimals, 0, 9));
    if (result.ec != std::errc{}) result = std::to_chars(begin, limit, value);
    return Append(std::string_view(begin, static_cast<std::size_t>(result.ptr - begin)));
  }

  std::string_view view() const { return {chars_.data(), size_}; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  static constexpr std::size_t capacity() { return N; }

 private:
  std::size_t size_ = 0;
  std::array<char, N> chars_{};
};

}  // namespace kawara::core
