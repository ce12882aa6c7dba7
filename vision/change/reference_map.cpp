#include "vision/change/reference_map.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::vision {

std::int64_t ReferenceMap::KeyOf(const VoxelIndex& v) {
  // 21 bits each: 524 km at half a metre.
  constexpr std::int64_t kMask = (std::int64_t{1} << 21) - 1;
  return ((v.x & kMask) << 42) | ((v.y & kMask) << 21) | (v.z & kMask);
}

VoxelIndex ReferenceMap::VoxelOf(const Eigen::Vector3d& p) {
  const auto index = [](double m) { return static_cast<std::int32_t>(std::floor(m / kVoxel)); };
  return {index(p.x()), index(p.y()), index(p.z())};
}

const ReferencePatch* ReferenceMap::Find(const VoxelIndex& voxel) const {
  const auto found = patches_.find(KeyOf(voxel));
  return found == patches_.end() ? nullptr : &found->second.second;
}

std::vector<std::pair<VoxelIndex, ReferencePatch>> ReferenceMap::Patches() const {
  std::vector<std::pair<VoxelIndex, ReferencePatch>> all;
  all.reserve(patches_.size());
  for (const auto& [key, patch] : patches_) all.push_back(patch);
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  return all;
}

std::optional<ReferenceMatch> ReferenceMap::Nearest(const Eigen::Vector3d& p,
                                                    double reach_m) const {
  if (patches_.empty()) return std::nullopt;
  const VoxelIndex low = VoxelOf(p - Eigen::Vector3d::Constant(reach_m));
  const VoxelIndex high = VoxelOf(p + Eigen::Vector3d::Constant(reach_m));
  std::optional<ReferenceMatch> best;
  for (std::int32_t z = low.z; z <= high.z; ++z)
    for (std::int32_t y = low.y; y <= high.y; ++y)
      for (std::int32_t x = low.x; x <= high.x; ++x) {
        const ReferencePatch* const patch = Find({x, y, z});
        if (patch == nullptr) continue;
        const Eigen::Vector3d centre = Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5) * kVoxel;
        const Eigen::Vector3d normal = patch->normal.cast<double>();
        const Eigen::Vector3d from = p - centre - patch->mean_m.cast<double>();
        const double along = std::abs(from.dot(normal));
        // The plane goes on a little beyond its voxel, as its neighbour may have been missed.
        const Eigen::Vector3d foot = p - normal * from.dot(normal);
        const Eigen::Vector3d beyond =
            ((foot - centre).cwiseAbs() - Eigen::Vector3d::Constant(kVoxel / 2)).cwiseMax(0.0);
        const double distance = std::hypot(along, std::max(0.0, beyond.norm() - kVoxel / 4));
        if (distance > reach_m || (best && distance >= best->distance_m)) continue;
        best = ReferenceMatch{
            distance, from.dot(normal),
            std::hypot(static_cast<double>(patch->sd_m), static_cast<double>(patch->thickness_m)),
            normal};
      }
  return best;
}

core::UtcTime ReferenceMap::Date() const {
  core::UtcTime newest;
  for (const ReferenceSource& source : sources)
    if (source.date.IsSet() && (!newest.IsSet() || source.date > newest)) newest = source.date;
  return newest;
}

}  // namespace kawara::vision
