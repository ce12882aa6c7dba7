#include "drivers/crc24q.hpp"

#include <array>
#include <cstddef>

namespace kawara::drivers {
namespace {

constexpr std::uint32_t kGenerator = 0x1864CFB;
constexpr std::uint32_t kMask = 0xFFFFFF;
constexpr std::size_t kSlices = 8;
using Tables = std::array<std::array<std::uint32_t, 256>, kSlices>;

/// tables[k][b] is the CRC of byte b followed by k zero bytes.
constexpr Tables MakeTables() {
  Tables tables{};
  for (std::uint32_t b = 0; b < 256; ++b) {
    std::uint32_t crc = b << 16;
    for (int bit = 0; bit < 8; ++bit) {
      crc <<= 1;
      if ((crc & 0x1000000) != 0) crc ^= kGenerator;
    }
    tables[0][b] = crc & kMask;
  }
  for (std::size_t k = 1; k < kSlices; ++k) {
    for (std::size_t b = 0; b < 256; ++b) {
      const std::uint32_t previous = tables[k - 1][b];
      tables[k][b] = ((previous << 8) & kMask) ^ tables[0][previous >> 16];
    }
  }
  return tables;
}
constexpr Tables kTables = MakeTables();

}  // namespace

std::uint32_t Crc24q(std::span<const std::uint8_t> bytes, std::uint32_t crc) noexcept {
  const std::uint8_t* p = bytes.data();
  std::size_t n = bytes.size();
  crc &= kMask;
  for (; n >= kSlices; n -= kSlices, p += kSlices) {
    // The running CRC covers the first three bytes of the block; the other five start from zero.
    crc = kTables[7][(crc >> 16) ^ p[0]] ^ kTables[6][((crc >> 8) & 0xFF) ^ p[1]] ^
          kTables[5][(crc & 0xFF) ^ p[2]] ^ kTables[4][p[3]] ^ kTables[3][p[4]] ^ kTables[2][p[5]] ^
          kTables[1][p[6]] ^ kTables[0][p[7]];
  }
  for (; n > 0; --n, ++p) crc = ((crc << 8) & kMask) ^ kTables[0][(crc >> 16) ^ *p];
  return crc;
}

}  // namespace kawara::drivers
