#include "drivers/crc24q.hpp"

#include <gtest/gtest.h>

#include "corrections_data.hpp"

namespace kawara::drivers {
namespace {

/// Long division bit by bit, as the standard writes it down.
std::uint32_t SlowCrc(std::span<const std::uint8_t> bytes) {
  std::uint32_t crc = 0;
  for (const std::uint8_t byte : bytes) {
    crc ^= std::uint32_t{byte} << 16;
    for (int bit = 0; bit < 8; ++bit) {
      crc <<= 1;
      if ((crc & 0x1000000U) != 0) crc ^= 0x1864CFBU;
    }
  }
  return crc;
}

testing::Bytes Noise(std::size_t size) {
  testing::Bytes bytes(size);
  std::uint32_t random = 7;
  for (auto& byte : bytes)
    byte = static_cast<std::uint8_t>((random = random * 1664525U + 1013904223U) >> 24);
  return bytes;
}

TEST(Crc24q, ExampleOfTheStandard) {
  const testing::Bytes frame{0xD3, 0x00, 0x13, 0x3E, 0xD7, 0xD3, 0x02, 0x02, 0x98,
                             0x0E, 0xDE, 0xEF, 0x34, 0xB4, 0xBD, 0x62, 0xAC, 0x09,
                             0x41, 0x98, 0x6F, 0x33, 0x36, 0x0B, 0x98};
  EXPECT_EQ(Crc24q(std::span(frame).first(22)), 0x360B98U);
  EXPECT_EQ(Crc24q(frame), 0U);
}

TEST(Crc24q, EqualsLongDivisionAtEveryLength) {
  const auto bytes = Noise(100);
  for (std::size_t n = 0; n <= bytes.size(); ++n) {
    EXPECT_EQ(Crc24q(std::span(bytes).first(n)), SlowCrc(std::span(bytes).first(n))) << n;
  }
}

TEST(Crc24q, GoesOnInPieces) {
  const auto bytes = Noise(64);
  const std::uint32_t whole = Crc24q(bytes);
  for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
    EXPECT_EQ(Crc24q(std::span(bytes).subspan(cut), Crc24q(std::span(bytes).first(cut))), whole)
        << cut;
  }
}

TEST(Crc24q, SeesEverySingleBit) {
  const auto bytes = Noise(40);
  const std::uint32_t whole = Crc24q(bytes);
  for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    auto damaged = bytes;
    damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ (1U << (bit % 8)));
    EXPECT_NE(Crc24q(damaged), whole) << bit;
  }
}

}  // namespace
}  // namespace kawara::drivers
