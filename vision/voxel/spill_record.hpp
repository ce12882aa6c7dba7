#pragma once
#include <zlib.h>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace kawara::vision {

// The bytes of a spill file (spill_file.hpp), for its reader and its writer.
static_assert(std::endian::native == std::endian::little);

constexpr std::array<char, 8> kSpillMagic{'K', 'W', 'S', 'P', 'I', 'L', 'L', '1'};
constexpr std::uint32_t kSpillTileMagic = 0x454C4954;    // "TILE"
constexpr std::uint32_t kSpillCommitMagic = 0x54494D43;  // "CMIT"

struct SpillFileHeader {
  std::array<char, 8> magic{};
  double voxel_m = 0.0;
  std::uint32_t reserved = 0;
  std::uint32_t crc = 0;
};
static_assert(sizeof(SpillFileHeader) == 24);

struct SpillRecordHeader {
  std::uint32_t magic = 0;
  std::int32_t x = 0, y = 0;
  std::uint32_t payload_bytes = 0;
  std::uint32_t payload_crc = 0;
  std::uint32_t crc = 0;
};
static_assert(sizeof(SpillRecordHeader) == 24);

struct SpillCommit {
  std::uint64_t progress = 0;
  std::uint64_t pictures = 0;
};

inline std::uint32_t Crc32(std::span<const std::uint8_t> bytes) {
  return static_cast<std::uint32_t>(::crc32_z(0, bytes.data(), bytes.size()));
}

/// Of everything before the field `crc`, which is the last.
template <class Header>
std::uint32_t CrcOfHeader(const Header& header) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&header);
  return Crc32({bytes, sizeof(Header) - sizeof(header.crc)});
}

}  // namespace kawara::vision
