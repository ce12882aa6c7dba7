#include "drivers/rtcm2_encoder.hpp"

#include <algorithm>

#include "drivers/rtcm2_word.hpp"

namespace kawara::drivers {

std::span<const std::uint8_t> Rtcm2Encoder::Encode(const Rtcm2Message& m) noexcept {
  if (!begun_) bits_before_ = m.bits_before & 3U;
  begun_ = true;
  std::size_t used = 0;
  const auto put = [&](std::uint32_t data24) {
    const std::uint32_t word = MakeRtcm2Word(data24, bits_before_);
    bits_before_ = word & 3U;
    for (unsigned i = 0; i < kRtcm2BytesPerWord; ++i) {
      const std::uint32_t sextet = (word >> (kRtcm2WordBits - kRtcm2BitsPerByte * (i + 1))) & 0x3FU;
      std::uint32_t byte = 0x40;
      for (unsigned bit = 0; bit < kRtcm2BitsPerByte; ++bit) {
        byte |= ((sextet >> (kRtcm2BitsPerByte - 1 - bit)) & 1U) << bit;
      }
      bytes_[used++] = static_cast<std::uint8_t>(byte);
    }
  };
  constexpr core::Duration kZUnit = std::chrono::milliseconds(600);
  const auto words = std::min<std::uint32_t>(m.data_words, 31);
  const auto z_count = static_cast<std::uint32_t>(m.time_of_hour / kZUnit) & 0x1FFFU;
  put((kRtcm2Preamble << 16) | ((m.type & 0x3FU) << 10) | (m.station & 0x3FFU));
  put((z_count << 11) | ((m.sequence & 7U) << 8) | (words << 3) | (m.health & 7U));
  for (std::size_t i = 0; i < words; ++i) put(m.data[i] & 0xFFFFFFU);
  return std::span<const std::uint8_t>(bytes_).first(used);
}

}  // namespace kawara::drivers
