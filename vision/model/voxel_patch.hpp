#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "vision/voxel/voxel_map.hpp"

namespace kawara::vision {

/// Which voxels are surface. Beyond what one voxel says of itself: wrong ranges come in scraps of
/// one picture, true surfaces are seen again and go on.
struct SurfaceRule {
  OccupancyRule occupancy;
  /// A voxel with so many votes counts by itself; one with fewer only if it touches such a one. 0:
  /// all count.
  int strong_hits = 0;
  /// Occupied voxels up to two away on every side, without which it is a scrap.
  int least_around = 0;
};

/// One occupied voxel as a piece of surface: where its votes lie, and which way they face.
struct Surfel {
  VoxelIndex index;
  Eigen::Vector3f centroid;                          ///< [voxels] from the patch's first voxel
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< unit, to the viewer; zero: nobody knows
  float weight = 0.0F;
  std::uint16_t hits = 0;
  std::array<float, 3> colour{};
};

/// The occupied voxels of a tile and of a margin around it, in an array that is quick to look
/// around in. Built once; immutable; any thread.
class VoxelPatch {
 public:
  static constexpr int kMargin = 8;  ///< voxels: surfaces of neighbouring tiles meet exactly
  static constexpr std::int32_t kNone = -1;

  /// Of what is in memory: a neighbour that was spilled must be brought back by the caller.
  VoxelPatch(const VoxelMap& map, const TileIndex& tile, const SurfaceRule& rule);

  const std::vector<Surfel>& surfels() const { return surfels_; }
  /// Number of the surfel in voxel (x, y, z) from the patch's first; kNone.
  std::int32_t At(int x, int y, int z) const {
    if (x < 0 || y < 0 || z < 0 || x >= side_ || y >= side_ || z >= height_) return kNone;
    return at_[PlaceOf(x, y, z)];
  }
  int side() const { return side_; }
  int height() const { return height_; }
  /// Voxel of the map where the patch begins.
  const VoxelIndex& first() const { return first_; }

  /// Voxel (x, y) of the patch lies in the tile itself, not in the margin.
  static bool IsInTile(int x, int y) {
    constexpr int kEnd = kMargin + kTileSide;
    return x >= kMargin && y >= kMargin && x < kEnd && y < kEnd;
  }

 private:
  void Collect(const VoxelMap& map, const OccupancyRule& rule);
  void Place();
  void DropUnsupported(const SurfaceRule& rule);
  template <class Count>
  int CountAround(const Surfel& surfel, int reach, const Count& count) const;
  void FindNormals();
  std::size_t PlaceOf(int x, int y, int z) const {
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
