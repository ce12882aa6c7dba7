#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "vision/voxel/voxel.hpp"
#include "vision/voxel/voxel_pool.hpp"

namespace kawara::vision {

/// Sparse space: blocks of 8^3 voxels behind an open hash table, and by tile in order. Blocks and
/// their voxels are taken from slabs and handed back, so memory follows what is held at the same
/// time. A pointer to a block is good until its tile is removed, one to a voxel until the next
/// AddVoxel to its block. One thread; reading from many.
class BlockGrid {
 public:
  /// Coordinates of blocks must lie within +-kMaxBlock (838 km at 10 cm).
  static constexpr std::int32_t kMaxBlock = (1 << 20) - 1;

  VoxelBlock* Find(const BlockIndex& index);
  const VoxelBlock* Find(const BlockIndex& index) const;
  /// Empty if new.
  VoxelBlock& FindOrMake(const BlockIndex& index);
  /// Voxel `place` (VoxelInBlock) of a block, made if it was never hit; returns its slot + 1.
  std::uint16_t AddVoxel(VoxelBlock& block, std::size_t place) {
    const std::uint16_t slot = block.slot[place];
    return slot != 0 ? slot : MakeVoxel(block, place);
  }
  /// Forgets a tile with all its blocks.
  void RemoveTile(const TileIndex& tile);

  /// Blocks of every tile in order of their making; tiles in order of their index.
  const std::map<TileIndex, std::vector<VoxelBlock*>>& tiles() const { return tiles_; }
  std::size_t blocks() const { return used_; }
  std::size_t memory_bytes() const;

 private:
  static constexpr std::size_t kSlabBlocks = 64;
  struct Entry {
    std::uint64_t key = 0;
    VoxelBlock* block = nullptr;  ///< null: free
  };

  static std::uint64_t KeyOf(const BlockIndex& index);
  std::size_t SlotOf(std::uint64_t key) const;  ///< of the key, or the free one where it belongs
  std::size_t HomeOf(std::uint64_t key) const;
  void Grow();
  void Erase(const BlockIndex& index);
  std::uint16_t MakeVoxel(VoxelBlock& block, std::size_t place);

  std::vector<Entry> table_ = std::vector<Entry>(64);
  std::size_t used_ = 0;
  std::map<TileIndex, std::vector<VoxelBlock*>> tiles_;
  std::vector<std::unique_ptr<VoxelBlock[]>> slabs_;
  std::vector<VoxelBlock*> free_;
  VoxelPool pool_;
};

}  // namespace kawara::vision
