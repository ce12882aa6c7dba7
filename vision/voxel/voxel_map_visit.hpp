#pragma once
#include <limits>

#include "vision/voxel/voxel_map.hpp"

namespace kawara::vision {

template <class Visit>
void VoxelMap::ForEachOccupied(const VoxelIndex& begin, const VoxelIndex& end,
                               const OccupancyRule& rule, const Visit& visit) const {
  for (const VoxelBlock* block : BlocksWithin(begin, end)) {
    block->ForEach([&](std::size_t place, const Voxel& voxel) {
      const auto i = static_cast<std::int32_t>(place);
      constexpr std::int32_t kMask = kBlockSide - 1;
      const VoxelIndex index{block->index.x * kBlockSide + (i & kMask),
                             block->index.y * kBlockSide + ((i >> kBlockBits) & kMask),
                             block->index.z * kBlockSide + (i >> (2 * kBlockBits))};
      if (index.x < begin.x || index.y < begin.y || index.z < begin.z || index.x >= end.x ||
          index.y >= end.y || index.z >= end.z)
        return;
      if (rule.Accepts(voxel)) visit(OccupiedVoxel{index, voxel});
    });
  }
}

template <class Visit>
void VoxelMap::ForEachOccupied(const OccupancyRule& rule, const Visit& visit) const {
  constexpr auto kLeast = std::numeric_limits<std::int32_t>::min();
  constexpr auto kMost = std::numeric_limits<std::int32_t>::max();
  ForEachOccupied({kLeast, kLeast, kLeast}, {kMost, kMost, kMost}, rule, visit);
}

}  // namespace kawara::vision
