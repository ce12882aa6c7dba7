#pragma once
#include <Eigen/Core>
#include <array>
#include <bit>
#include <compare>
#include <cstddef>
#include <cstdint>

namespace kawara::vision {

/// What a cube of space has been told by all pictures so far. The paper's voxel space (section 4C)
/// counts votes; here a vote also weighs 1 / variance, says where in the cube it fell, which colour
/// it had and from where it was seen, and other pictures may have looked through.
struct alignas(32) Voxel {
  static constexpr int kColourOne = 64;  ///< fixed point of `colour`
  static constexpr int kViewOne = 8191;  ///< fixed point of `to_viewer`
  static constexpr int kMeanVotes = 64;  ///< colour and view are running means over so many votes

  std::array<float, 3> moment{};  ///< sum of weight * (vote - centre of the voxel), in voxels
  float weight = 0.0F;            ///< sum of 1 / variance [1/m^2]
  std::array<std::int16_t, 3> colour{};     ///< RGB, 0..255 * kColourOne
  std::array<std::int16_t, 3> to_viewer{};  ///< mean unit direction to the cameras * kViewOne, map
  std::uint16_t hits = 0;                   ///< votes; 0: never hit
  std::uint16_t see_through = 0;            ///< rays that ended behind, in the unit of `hits`
};
static_assert(sizeof(Voxel) == 32);

/// Both counters halved before one runs over: their ratio stays, and both are far above any
/// threshold.
inline void HalveCounters(Voxel& v) {
  v.hits /= 2;
  v.see_through /= 2;
}

/// Voxel (x, y, z) covers [x, x + 1) * voxel_m and so on, in the map's frame.
struct VoxelIndex {
  std::int32_t x = 0, y = 0, z = 0;
  auto operator<=>(const VoxelIndex&) const = default;
};

constexpr int kBlockBits = 3;
constexpr int kBlockSide = 1 << kBlockBits;  ///< voxels
constexpr int kBlockVoxels = kBlockSide * kBlockSide * kBlockSide;
constexpr int kTileBits = 6;
constexpr int kTileSide = 1 << kTileBits;  ///< voxels

/// Block (x, y, z) covers voxels [8 x, 8 x + 8) and so on.
using BlockIndex = VoxelIndex;

/// A square column of space, 64 x 64 voxels wide and as high as there is anything: what is written
/// out, brought back and modelled as one. Tile (x, y) covers voxels [64 x, 64 x + 64) and so on.
struct TileIndex {
  std::int32_t x = 0, y = 0;
  auto operator<=>(const TileIndex&) const = default;
};

inline TileIndex TileOfBlock(const BlockIndex& block) {
  constexpr int kShift = kTileBits - kBlockBits;
  return {block.x >> kShift, block.y >> kShift};
}

/// Place of a voxel in its block, z slowest.
inline int VoxelInBlock(int x, int y, int z) {
  return ((z & (kBlockSide - 1)) << (2 * kBlockBits)) | ((y & (kBlockSide - 1)) << kBlockBits) |
         (x & (kBlockSide - 1));
}

/// 8 x 8 x 8 voxels, of which only those that were ever hit take memory: noise touches many blocks
/// and few voxels in each. BlockGrid makes them and owns what they point to.
struct VoxelBlock {
  BlockIndex index;
  std::uint64_t revision = 0;  ///< number of the picture that last changed it, from 1
  Voxel* voxels = nullptr;     ///< `count` of them in order of their first hit
  std::uint16_t count = 0, capacity = 0;
  std::array<std::uint64_t, kBlockVoxels / 64> any{};  ///< a bit for each that was hit
  std::array<std::uint16_t, kBlockVoxels> slot{};      ///< place in `voxels` + 1; 0: never hit

  /// Calls visit(place in the block, Voxel&) for those that were hit, in order of the place.
  template <class Visit>
  void ForEach(const Visit& visit) const {
    for (std::size_t word = 0; word < any.size(); ++word) {
      for (std::uint64_t bits = any[word]; bits != 0; bits &= bits - 1) {
        const std::size_t i = word * 64 + static_cast<std::size_t>(std::countr_zero(bits));
        visit(i, voxels[slot[i] - 1]);
      }
    }
  }
};

/// When a voxel counts as surface.
struct OccupancyRule {
  int min_hits = 3;
  double min_weight = 0.0;     ///< [1/m^2]; 1/0.05^2 = the mean of the votes is good to 5 cm
  double min_hit_share = 0.5;  ///< of hits + see_through
  bool Accepts(const Voxel& v) const {
    const double all = static_cast<double>(v.hits) + static_cast<double>(v.see_through);
    return v.hits > 0 && v.hits >= min_hits && static_cast<double>(v.weight) >= min_weight &&
           static_cast<double>(v.hits) >= min_hit_share * all;
  }
};

/// Weighted mean of the votes [voxels, from the map's origin].
inline Eigen::Vector3d CentroidVoxels(const VoxelIndex& index, const Voxel& v) {
  const double scale = 1.0 / static_cast<double>(v.weight);
  return {index.x + 0.5 + static_cast<double>(v.moment[0]) * scale,
          index.y + 0.5 + static_cast<double>(v.moment[1]) * scale,
          index.z + 0.5 + static_cast<double>(v.moment[2]) * scale};
}

inline std::array<std::uint8_t, 3> ColourOf(const Voxel& v) {
  std::array<std::uint8_t, 3> rgb{};
  for (std::size_t c = 0; c < 3; ++c)
    rgb[c] = static_cast<std::uint8_t>((v.colour[c] + Voxel::kColourOne / 2) / Voxel::kColourOne);
  return rgb;
}

}  // namespace kawara::vision
