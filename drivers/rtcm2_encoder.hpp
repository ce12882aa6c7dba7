#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "drivers/rtcm2.hpp"

namespace kawara::drivers {

/// Writes RTCM 2 messages in the 6-of-8 byte form, each byte-aligned, parity and inversion chained
/// from one to the next. The first message takes the two bits before it from the message
/// (Rtcm2Message::bits_before), so a stream that was byte-aligned and complete comes out as it went
/// in. No allocation. One thread.
class Rtcm2Encoder {
 public:
  static constexpr std::size_t kMaxBytes = std::size_t{33} * 5;

  /// Header fields, data_words and data are written; `body` is not looked at. Valid until the next
  /// call.
  std::span<const std::uint8_t> Encode(const Rtcm2Message& message) noexcept;

 private:
  bool begun_ = false;
  std::uint32_t bits_before_ = 0;
  std::array<std::uint8_t, kMaxBytes> bytes_{};
};

}  // namespace kawara::drivers
