#pragma once
#include <array>
#include <bit>
#include <cstddef>
#include <memory>
#include <vector>

#include "core/check.hpp"
#include "vision/voxel/voxel.hpp"

namespace kawara::vision {

/// Rows of 4, 8, 16 ... 512 voxels out of large slabs; what is handed back is used again for rows
/// of the same length. Contents are not initialised. One thread.
class VoxelPool {
 public:
  static constexpr std::size_t kLeast = 4;

  /// `capacity` must be one of the above.
  Voxel* Allocate(std::size_t capacity) {
    auto& free = free_[ClassOf(capacity)];
    if (!free.empty()) {
      Voxel* const row = free.back();
      free.pop_back();
      return row;
    }
    if (left_ < capacity) {
      // The rest of the slab becomes rows, the largest first.
      while (left_ >= kLeast) {
        const std::size_t row = std::bit_floor(left_);
        left_ -= row;
        free_[ClassOf(row)].push_back(slabs_.back().get() + left_);
      }
      slabs_.push_back(std::make_unique_for_overwrite<Voxel[]>(kSlabVoxels));
      left_ = kSlabVoxels;
    }
    left_ -= capacity;
    return slabs_.back().get() + left_;
  }
  void Free(Voxel* row, std::size_t capacity) { free_[ClassOf(capacity)].push_back(row); }

  std::size_t memory_bytes() const { return slabs_.size() * kSlabVoxels * sizeof(Voxel); }

 private:
  static constexpr std::size_t kSlabVoxels = 8192;  // 256 kB
  static constexpr std::size_t kClasses = 8;

  static std::size_t ClassOf(std::size_t capacity) {
    CORE_CHECK(std::has_single_bit(capacity) && capacity >= kLeast && capacity <= kBlockVoxels);
    return static_cast<std::size_t>(std::countr_zero(capacity / kLeast));
  }

  std::vector<std::unique_ptr<Voxel[]>> slabs_;
  std::size_t left_ = 0;  ///< of the last slab, from its front
  std::array<std::vector<Voxel*>, kClasses> free_;
};

}  // namespace kawara::vision
