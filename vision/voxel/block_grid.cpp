#include "vision/voxel/block_grid.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "core/check.hpp"

namespace kawara::vision {

std::uint64_t BlockGrid::KeyOf(const BlockIndex& index) {
  const auto biased = [](std::int32_t v) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(v + kMaxBlock + 1));
  };
  return (biased(index.z) << 42) | (biased(index.y) << 21) | biased(index.x);
}

std::size_t BlockGrid::HomeOf(std::uint64_t key) const {
  // Fibonacci hashing: the upper bits of the product mix all of the key's.
  const int bits = std::countr_zero(table_.size());
  return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15ULL) >> (64 - bits));
}

std::size_t BlockGrid::SlotOf(std::uint64_t key) const {
  std::size_t slot = HomeOf(key);
  while (table_[slot].block != nullptr && table_[slot].key != key)
    slot = (slot + 1) & (table_.size() - 1);
  return slot;
}

VoxelBlock* BlockGrid::Find(const BlockIndex& index) { return table_[SlotOf(KeyOf(index))].block; }

const VoxelBlock* BlockGrid::Find(const BlockIndex& index) const {
  return table_[SlotOf(KeyOf(index))].block;
}

VoxelBlock& BlockGrid::FindOrMake(const BlockIndex& index) {
  const std::uint64_t key = KeyOf(index);
  std::size_t slot = SlotOf(key);
  if (table_[slot].block != nullptr) return *table_[slot].block;
  CORE_CHECK(std::abs(index.x) <= kMaxBlock && std::abs(index.y) <= kMaxBlock &&
             std::abs(index.z) <= kMaxBlock);
  if (2 * (used_ + 1) > table_.size()) {
    Grow();
    slot = SlotOf(key);
  }
  if (free_.empty()) {
    slabs_.push_back(std::make_unique<VoxelBlock[]>(kSlabBlocks));
    for (std::size_t i = kSlabBlocks; i-- > 0;) free_.push_back(&slabs_.back()[i]);
  }
  VoxelBlock* const block = free_.back();
  free_.pop_back();
  *block = VoxelBlock{};
  block->index = index;
  table_[slot] = {key, block};
  ++used_;
  tiles_[TileOfBlock(index)].push_back(block);
  return *block;
}

void BlockGrid::Grow() {
  std::vector<Entry> old(table_.size() * 2);
  old.swap(table_);
  for (const Entry& entry : old)
    if (entry.block != nullptr) table_[SlotOf(entry.key)] = entry;
}

void BlockGrid::Erase(const BlockIndex& index) {
  std::size_t hole = SlotOf(KeyOf(index));
  const std::size_t mask = table_.size() - 1;
  // What was pushed past the hole moves back into it: no tombstones, so long drives stay fast.
  for (std::size_t next = (hole + 1) & mask; table_[next].block != nullptr;
       next = (next + 1) & mask) {
    const std::size_t home = HomeOf(table_[next].key);
    if (((next - home) & mask) < ((next - hole) & mask)) continue;
    table_[hole] = table_[next];
    hole = next;
  }
  table_[hole] = {};
  --used_;
}

void BlockGrid::RemoveTile(const TileIndex& tile) {
  const auto found = tiles_.find(tile);
  if (found == tiles_.end()) return;
  for (VoxelBlock* block : found->second) {
    Erase(block->index);
    pool_.Free(block->voxels, block->capacity);
    free_.push_back(block);
  }
  tiles_.erase(found);
}

std::uint16_t BlockGrid::MakeVoxel(VoxelBlock& block, std::size_t place) {
  if (block.count == block.capacity) {
    const auto more =
        static_cast<std::uint16_t>(block.capacity == 0 ? VoxelPool::kLeast : 2 * block.capacity);
    Voxel* const larger = pool_.Allocate(more);
    std::copy_n(block.voxels, block.count, larger);
    if (block.capacity > 0) pool_.Free(block.voxels, block.capacity);
    block.voxels = larger;
    block.capacity = more;
  }
  block.voxels[block.count] = Voxel{};
  block.any[place >> 6] |= std::uint64_t{1} << (place & 63U);
  return block.slot[place] = ++block.count;
}

std::size_t BlockGrid::memory_bytes() const {
  return slabs_.size() * kSlabBlocks * sizeof(VoxelBlock) + table_.size() * sizeof(Entry) +
         pool_.memory_bytes();
}

}  // namespace kawara::vision
