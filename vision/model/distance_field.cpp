#include "vision/model/distance_field.hpp"

#include <cstddef>

#include "core/check.hpp"

namespace kawara::vision {
namespace {

constexpr int kReach = 3;               // voxels on each side of the corner
constexpr float kWidthVoxels = 1.2F;    // standard deviation of the kernel
constexpr float kNearestVoxels = 1.8F;  // farther than this from all votes nothing is known

}  // namespace

DistanceField::DistanceField(const VoxelPatch& patch)
    : patch_(patch),
      number_(static_cast<std::size_t>(patch.side()) * static_cast<std::size_t>(patch.side()) *
                  static_cast<std::size_t>(patch.height()),
              -1) {
  samples_.reserve(8 * patch.surfels().size());
}

const FieldSample& DistanceField::At(int x, int y, int z) {
  CORE_CHECK(x >= 0 && y >= 0 && z >= 0 && x < patch_.side() && y < patch_.side() &&
             z < patch_.height());
  std::int32_t& number =
      number_[(static_cast<std::size_t>(z) * static_cast<std::size_t>(patch_.side()) +
               static_cast<std::size_t>(y)) *
                  static_cast<std::size_t>(patch_.side()) +
              static_cast<std::size_t>(x)];
  if (number < 0) {
    number = static_cast<std::int32_t>(samples_.size());
    samples_.push_back(Sample(x, y, z));
  }
  return samples_[static_cast<std::size_t>(number)];
}

FieldSample DistanceField::Sample(int x, int y, int z) const {
  const Eigen::Vector3f corner(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
  float weights = 0.0F, distance = 0.0F, nearest2 = kNearestVoxels * kNearestVoxels;
  bool known = false;
  FieldSample sample;
  for (int dz = -kReach; dz < kReach; ++dz) {
    for (int dy = -kReach; dy < kReach; ++dy) {
      for (int dx = -kReach; dx < kReach; ++dx) {
        const std::int32_t n = patch_.At(x + dx, y + dy, z + dz);
        if (n == VoxelPatch::kNone) continue;
        const Surfel& s = patch_.surfels()[static_cast<std::size_t>(n)];
        if (s.normal.isZero(0.0F)) continue;
        const Eigen::Vector3f from = corner - s.centroid;
        const float d2 = from.squaredNorm();
        if (d2 <= nearest2) known = true;
        const float w = s.weight * std::exp(d2 * (-0.5F / (kWidthVoxels * kWidthVoxels)));
        weights += w;
        distance += w * s.normal.dot(from);
        sample.normal += w * s.normal;
        for (std::size_t c = 0; c < 3; ++c) sample.colour[c] += w * s.colour[c];
      }
    }
  }
  // Normals that cancel belong to two surfaces back to back: no side is outside.
  if (!known || !(weights > 0.0F) || sample.normal.norm() < 0.2F * weights) return {};
  sample.distance = distance / weights;
  sample.normal.normalize();
  for (float& c : sample.colour) c /= weights;
  return sample;
}

}  // namespace kawara::vision
