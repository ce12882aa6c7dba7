#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/expected.hpp"
#include "vision/voxel/voxel.hpp"

namespace kawara::vision {

/// Blocks of a tile as bytes: their number, then for each its index, revision, the map of voxels
/// that were hit, and these. Little-endian. In order of the blocks given.
std::vector<std::uint8_t> EncodeTile(std::span<VoxelBlock* const> blocks);

/// A block as it was written.
struct SpilledBlock {
  BlockIndex index;
  std::uint64_t revision = 0;
  std::size_t size = 0;  ///< of the two below
  std::array<std::uint16_t, kBlockVoxels> places{};
  std::array<Voxel, kBlockVoxels> voxels{};
};

/// Reads them back one after the other. Every number is checked: a block outside `tile`, a voxel
/// that no votes can make, bytes too few or too many.
class TileDecoder {
 public:
  TileDecoder(std::span<const std::uint8_t> bytes, const TileIndex& tile)
      : bytes_(bytes), tile_(tile) {}
  /// The next block into `block`; false: that was the last. Errors: kFormat.
  core::Expected<bool> Next(SpilledBlock& block);

 private:
  template <class T>
  bool Take(T& value);

  std::span<const std::uint8_t> bytes_;
  TileIndex tile_;
  bool begun_ = false;
  std::uint32_t left_ = 0;
};

}  // namespace kawara::vision
