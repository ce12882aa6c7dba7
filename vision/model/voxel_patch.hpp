#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "vision/voxel/voxel_map.hpp"

namespace kawara::vision {

/// One occupied voxel as a piece of surface: where its votes lie, and which way they face.
struct Surfel {
  VoxelIndex index;
  Eigen::Vector3f centroid;                          ///< [voxels] from the patch's first voxel
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< unit, to the viewer; zero: nobody knows
  float weight = 0.0F;
  std::array<float, 3> colour{};
};

/// The occupied voxels of a tile and of a margin around it, in an array that is quick to look
/// around in. Built once; immutable; any thread.
class VoxelPatch {
 public:
  static constexpr int kMargin = 6;  ///< voxels: surfaces of neighbouring tiles meet exactly
  static constexpr std::int32_t kNone = -1;

  /// Of what is in memory: a neighbour that was spilled must be brought back by the caller.
  VoxelPatch(const VoxelMap& map, const TileIndex& tile, const OccupancyRule& rule);

  const std::vector<Surfel>& surfels() const { return surfels_; }
  /// Number of the surfel in voxel (x, y, z) from the patch's first; kNone.
  std::int32_t At(int x, int y, int z) const {
    if (x < 0 || y < 0 || z < 0 || x >= side_ || y >= side_ || z >= height_) return kNone;
    return at_[Place(x, y, z)];
  }
  int side() const { return side_; }
  int height() const { return height_; }
  /// Voxel of the map where the patch begins.
  const VoxelIndex& first() const { return first_; }

 private:
  void FindNormals();
  std::size_t Place(int x, int y, int z) const {
    const auto side = static_cast<std::size_t>(side_);
    return (static_cast<std::size_t>(z) * side + static_cast<std::size_t>(y)) * side +
           static_cast<std::size_t>(x);
  }

  int side_ = kTileSide + 2 * kMargin;
  int height_ = 0;
  VoxelIndex first_;
  std::vector<Surfel> surfels_;
  std::vector<std::int32_t> at_;
};

}  // namespace kawara::vision
