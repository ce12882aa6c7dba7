#pragma once
#include <array>
#include <bit>
#include <cstdint>

/// The 30-bit words of RTCM 2: 24 data bits, 6 parity bits. In a 32-bit register the two top bits
/// are the last two of the word before; they enter the parity, and the lower one says that the 24
/// data bits are inverted. Source: IS-GPS-200, section 20.3.5.2 and table 20-XIV.
namespace kawara::drivers {

constexpr unsigned kRtcm2WordBits = 30;
constexpr unsigned kRtcm2BitsPerByte = 6;
constexpr unsigned kRtcm2BytesPerWord = kRtcm2WordBits / kRtcm2BitsPerByte;
constexpr std::uint32_t kRtcm2Preamble = 0x66;
constexpr std::uint32_t kRtcm2DataMask = 0x3FFFFFC0;
constexpr std::uint32_t kRtcm2InvertBit = 0x40000000;

/// Parity of a register whose data bits are not inverted.
constexpr std::uint32_t Rtcm2Parity(std::uint32_t word) {
  constexpr std::array<std::uint32_t, 6> kEquations{0xBB1F3480, 0x5D8F9A40, 0xAEC7CD00,
                                                    0x5763E680, 0x6BB1F340, 0x8B7A89C0};
  std::uint32_t parity = 0;
  for (const std::uint32_t mask : kEquations) {
    parity = (parity << 1) | (static_cast<std::uint32_t>(std::popcount(word & mask)) & 1U);
  }
  return parity;
}

/// Undoes the inversion; false if the parity is wrong (data24 is filled all the same).
constexpr bool ReadRtcm2Word(std::uint32_t word, std::uint32_t& data24) {
  if ((word & kRtcm2InvertBit) != 0) word ^= kRtcm2DataMask;
  data24 = (word & kRtcm2DataMask) >> 6;
  return Rtcm2Parity(word) == (word & 0x3FU);
}

/// The 30 bits to send for 24 data bits after a word that ended with `bits_before`.
constexpr std::uint32_t MakeRtcm2Word(std::uint32_t data24, std::uint32_t bits_before) {
  std::uint32_t word = (bits_before << kRtcm2WordBits) | (data24 << 6);
  word |= Rtcm2Parity(word);
  if ((word & kRtcm2InvertBit) != 0) word ^= kRtcm2DataMask;
  return word & 0x3FFFFFFF;
}

}  // namespace kawara::drivers
