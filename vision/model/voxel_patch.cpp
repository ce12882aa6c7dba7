#include "vision/model/voxel_patch.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>

namespace kawara::vision {
namespace {

constexpr int kNormalReach = 2;      // voxels
constexpr int kLeastNeighbours = 4;  // three points always lie in a plane

}  // namespace

VoxelPatch::VoxelPatch(const VoxelMap& map, const TileIndex& tile, const SurfaceRule& rule) {
  first_ = {tile.x * kTileSide - kMargin, tile.y * kTileSide - kMargin, 0};
  Collect(map, rule.occupancy);
  if (surfels_.empty()) return;
  Place();
  DropUnsupported(rule);
  FindNormals();
}

void VoxelPatch::Collect(const VoxelMap& map, const OccupancyRule& rule) {
  constexpr auto kLeast = std::numeric_limits<std::int32_t>::min();
  constexpr auto kMost = std::numeric_limits<std::int32_t>::max();
  std::int32_t low = kMost, high = kLeast;
  map.ForEachOccupied({first_.x, first_.y, kLeast}, {first_.x + side_, first_.y + side_, kMost},
                      rule, [&](const OccupiedVoxel& v) {
                        low = std::min(low, v.index.z);
                        high = std::max(high, v.index.z);
                        Surfel surfel;
                        surfel.index = v.index;
                        surfel.weight = v.voxel.weight;
                        surfel.hits = v.voxel.hits;
                        const auto rgb = ColourOf(v.voxel);
                        std::copy(rgb.begin(), rgb.end(), surfel.colour.begin());
                        // For the time being the view; FindNormals() looks at the neighbours.
                        surfel.normal = Eigen::Vector3f(v.voxel.to_viewer[0], v.voxel.to_viewer[1],
                                                        v.voxel.to_viewer[2]);
                        const float scale = 1.0F / v.voxel.weight;
                        surfel.centroid = {v.voxel.moment[0] * scale, v.voxel.moment[1] * scale,
                                           v.voxel.moment[2] * scale};
                        surfels_.push_back(surfel);
                      });
  if (surfels_.empty()) return;
  first_.z = low - kMargin;
  height_ = high - low + 1 + 2 * kMargin;
}

void VoxelPatch::Place() {
  at_.assign(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_) *
                 static_cast<std::size_t>(height_),
             kNone);
  for (std::size_t i = 0; i < surfels_.size(); ++i) {
    Surfel& s = surfels_[i];
    const int x = s.index.x - first_.x, y = s.index.y - first_.y, z = s.index.z - first_.z;
    s.centroid +=
        Eigen::Vector3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)) +
        Eigen::Vector3f::Constant(0.5F);
    at_[PlaceOf(x, y, z)] = static_cast<std::int32_t>(i);
  }
}

/// Of those up to `reach` voxels away on every side, without itself, that `count` is true for.
template <class Count>
int VoxelPatch::CountAround(const Surfel& surfel, int reach, const Count& count) const {
  const int x = surfel.index.x - first_.x, y = surfel.index.y - first_.y,
            z = surfel.index.z - first_.z;
  int found = 0;
  for (int dz = -reach; dz <= reach; ++dz) {
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        if (dx == 0 && dy == 0 && dz == 0) continue;
        const std::int32_t n = At(x + dx, y + dy, z + dz);
        if (n != kNone && count(static_cast<std::size_t>(n))) ++found;
      }
    }
  }
  return found;
}

// Both judged by neighbours as they were collected, in two rounds: a margin of one and two voxels
// more than the surface needs makes neighbouring tiles judge alike.
void VoxelPatch::DropUnsupported(const SurfaceRule& rule) {
  const auto drop = [this](const auto& keep) {
    std::vector<bool> kept(surfels_.size());
    for (std::size_t i = 0; i < surfels_.size(); ++i) kept[i] = keep(surfels_[i]);
    for (std::size_t i = 0; i < surfels_.size(); ++i) {
      if (kept[i]) continue;
      const VoxelIndex& at = surfels_[i].index;
      at_[PlaceOf(at.x - first_.x, at.y - first_.y, at.z - first_.z)] = kNone;
      surfels_[i].hits = 0;
    }
  };
  const auto strong = [&](std::size_t n) { return surfels_[n].hits >= rule.strong_hits; };
  drop(
      [&](const Surfel& s) { return s.hits >= rule.strong_hits || CountAround(s, 1, strong) > 0; });
  drop([&](const Surfel& s) {
    return s.hits > 0 && (rule.least_around == 0 ||
                          CountAround(s, 2, [](std::size_t) { return true; }) >= rule.least_around);
  });
  std::erase_if(surfels_, [](const Surfel& s) { return s.hits == 0; });
  for (std::size_t i = 0; i < surfels_.size(); ++i) {
    const VoxelIndex& at = surfels_[i].index;
    at_[PlaceOf(at.x - first_.x, at.y - first_.y, at.z - first_.z)] = static_cast<std::int32_t>(i);
  }
}

// A plane through the votes around: least principal axis of the neighbours' centroids, each with
// the weight of its votes, turned to where they were seen from.
void VoxelPatch::FindNormals() {
  for (Surfel& s : surfels_) {
    const int x = s.index.x - first_.x, y = s.index.y - first_.y, z = s.index.z - first_.z;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
    double weight = 0.0;
    int neighbours = 0;
    for (int dz = -kNormalReach; dz <= kNormalReach; ++dz) {
      for (int dy = -kNormalReach; dy <= kNormalReach; ++dy) {
        for (int dx = -kNormalReach; dx <= kNormalReach; ++dx) {
          const std::int32_t n = At(x + dx, y + dy, z + dz);
          if (n == kNone) continue;
          const Surfel& other = surfels_[static_cast<std::size_t>(n)];
          const Eigen::Vector3d d = (other.centroid - s.centroid).cast<double>();
          const double w = static_cast<double>(other.weight);
          mean += w * d;
          square += w * d * d.transpose();
          weight += w;
          ++neighbours;
        }
      }
    }
    const Eigen::Vector3f view = s.normal;
    s.normal.setZero();
    if (neighbours < kLeastNeighbours) continue;
    mean /= weight;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes;
    axes.computeDirect(square / weight - mean * mean.transpose());
    const Eigen::Vector3f normal = axes.eigenvectors().col(0).cast<float>();
    if (!normal.allFinite()) continue;
    s.normal = normal.dot(view) < 0.0F ? Eigen::Vector3f(-normal) : normal;
  }
}

}  // namespace kawara::vision
