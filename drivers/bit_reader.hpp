#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace kawara::drivers {

/// Reads big-endian bit fields (most significant bit first) from bytes, front to back, as RTCM
/// packs them. Reading past the end yields zeros and makes ok() false for good, so a decoder reads
/// all its fields and asks once. Real-time safe.
class BitReader {
 public:
  explicit BitReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  /// `bits` 0..64.
  std::uint64_t Unsigned(unsigned bits) noexcept {
    if (bits > bits_left()) {
      position_ = bytes_.size() * 8;
      ok_ = false;
      return 0;
    }
    std::uint64_t value = 0;
    while (bits > 0) {
      const unsigned in_byte = 8U - static_cast<unsigned>(position_ % 8U);
      const unsigned take = bits < in_byte ? bits : in_byte;
      const std::uint64_t byte = bytes_[position_ / 8];
      const std::uint64_t mask = (std::uint64_t{1} << take) - 1;
      value = (value << take) | ((byte >> (in_byte - take)) & mask);
      position_ += take;
      bits -= take;
    }
    return value;
  }
  /// Two's complement, `bits` 1..64.
  std::int64_t Signed(unsigned bits) noexcept {
    const std::uint64_t raw = Unsigned(bits);
    const std::uint64_t sign = std::uint64_t{1} << (bits - 1);
    return static_cast<std::int64_t>((raw ^ sign) - sign);
  }
  bool Flag() noexcept { return Unsigned(1) != 0; }
  template <class T>
  T As(unsigned bits) noexcept {
    return static_cast<T>(Unsigned(bits));
  }
  void Skip(std::size_t bits) noexcept {
    if (bits > bits_left()) {
      position_ = bytes_.size() * 8;
      ok_ = false;
    } else {
      position_ += bits;
    }
  }
  std::size_t position() const { return position_; }
  std::size_t bits_left() const { return bytes_.size() * 8 - position_; }
  bool ok() const { return ok_; }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t position_ = 0;
  bool ok_ = true;
};

}  // namespace kawara::drivers
