#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "vision/voxel/voxel.hpp"

namespace kawara::vision {

/// Some pixels' votes on their way: computed together, then their voxels are fetched into the cache
/// together, then added.
struct VoteBatch {
  static constexpr std::size_t kMost = 256;
  template <class T>
  using Column = std::array<T, kMost>;

  std::size_t size = 0;
  Column<std::uint32_t> pixel;
  Column<float> range_m, weight;
  Column<float> x, y, z;        ///< unit ray of the camera, then the point [voxels, window]
  Column<std::uint32_t> block;  ///< place in the window
  Column<std::uint16_t> in_block;
  /// Like Voxel::colour and to_viewer; two more for the register.
  Column<std::array<std::int16_t, 8>> looks;
  Column<std::uint16_t> slot;  ///< + 1
  Column<VoxelBlock*> at;
};

}  // namespace kawara::vision
