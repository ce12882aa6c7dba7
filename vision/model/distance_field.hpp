#pragma once
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "vision/model/voxel_patch.hpp"

namespace kawara::vision {

/// What the voxels around a lattice corner say about it.
struct FieldSample {
  float distance = std::numeric_limits<float>::quiet_NaN();  ///< [voxels], outside positive
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  std::array<float, 3> colour{};
  bool known() const { return !std::isnan(distance); }
};

/// Signed distance at the corners of a patch's lattice, computed when first asked for: only corners
/// near a surface ever are. Corner (x, y, z) is the lower one of voxel (x, y, z). One thread.
class DistanceField {
 public:
  explicit DistanceField(const VoxelPatch& patch);
  const FieldSample& At(int x, int y, int z);

 private:
  FieldSample Sample(int x, int y, int z) const;

  const VoxelPatch& patch_;
  std::vector<std::int32_t> number_;  ///< into samples_; negative: not computed
  std::vector<FieldSample> samples_;
};

}  // namespace kawara::vision
