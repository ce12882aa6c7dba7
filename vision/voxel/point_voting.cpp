#include <algorithm>
#include <cmath>
#include <cstdint>

#include "vision/voxel/voxel_map.hpp"

namespace kawara::vision {
namespace {

/// Running mean in fixed point over at most Voxel::kMeanVotes votes, this one included.
std::int16_t Mean(std::int16_t old, float vote, int votes) {
  if (votes == 1) return static_cast<std::int16_t>(std::lround(vote));
  const float gain = 1.0F / static_cast<float>(std::min(votes, Voxel::kMeanVotes));
  return static_cast<std::int16_t>(
      std::lround(static_cast<float>(old) + gain * (vote - static_cast<float>(old))));
}

void Add(Voxel& v, const Eigen::Vector3f& offset, const PointVote& point) {
  constexpr float kLeastSd = 1e-4F;
  const float sd = std::max(point.sd_m, kLeastSd), weight = 1.0F / (sd * sd);
  if (v.hits == 0xFFFF) HalveCounters(v);
  ++v.hits;
  v.weight += weight;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    v.moment[i] += weight * offset[axis];
    v.colour[i] =
        Mean(v.colour[i], static_cast<float>(point.colour[i] * Voxel::kColourOne), v.hits);
    v.to_viewer[i] = Mean(v.to_viewer[i], point.to_viewer[axis] * Voxel::kViewOne, v.hits);
  }
}

}  // namespace

core::Expected<void> VoxelMap::Vote(std::span<const PointVote> points) {
  ++pictures_;
  ++counts_.pictures;
  constexpr double kMostVoxel = double{kBlockSide} * BlockGrid::kMaxBlock;
  BlockIndex last{};
  VoxelBlock* block = nullptr;
  for (const PointVote& point : points) {
    const Eigen::Vector3d voxels = point.position_m / config_.voxel_m;
    if (!(voxels.cwiseAbs().maxCoeff() < kMostVoxel) || !point.to_viewer.allFinite() ||
        !(point.sd_m > 0.0F)) {
      ++counts_.dropped_far;
      continue;
    }
    const VoxelIndex at{static_cast<std::int32_t>(std::floor(voxels.x())),
                        static_cast<std::int32_t>(std::floor(voxels.y())),
                        static_cast<std::int32_t>(std::floor(voxels.z()))};
    const BlockIndex index{at.x >> kBlockBits, at.y >> kBlockBits, at.z >> kBlockBits};
    if (block == nullptr || index != last) {
      const TileIndex tile = TileOfBlock(index);
      if (auto back = Return(tile); !back) return back;
      block = &grid_.FindOrMake(index);
      last = index;
      block->revision = pictures_;
    }
    const auto place = static_cast<std::size_t>(VoxelInBlock(at.x, at.y, at.z));
    const std::uint16_t slot = grid_.AddVoxel(*block, place);
    const Eigen::Vector3d offset = voxels - Eigen::Vector3d(at.x + 0.5, at.y + 0.5, at.z + 0.5);
    Add(block->voxels[slot - 1], offset.cast<float>(), point);
    ++counts_.votes;
  }
  return {};
}

}  // namespace kawara::vision
