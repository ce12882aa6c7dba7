#pragma once
#include <memory>

#include "tests/support/box_world.hpp"
#include "tests/support/test_doughnut.hpp"
#include "vision/voxel/voxel_map.hpp"

namespace kawara::vision {

/// A drive of a small doughnut camera along a street with a wall and a car-sized box.
class StreetDrive {
 public:
  explicit StreetDrive(double sd_per_m2 = 0.002, int size_px = 256, std::uint64_t seed = 1)
      : camera_(*DoughnutCamera::Create(TestDoughnut(size_px))),
        rays_(camera_),
        sd_per_m2_(sd_per_m2),
        random_(seed) {
    world.boxes.emplace_back(Eigen::Vector3d(-20, 4, 0), Eigen::Vector3d(60, 5, 4));
    world.boxes.emplace_back(Eigen::Vector3d(3, -4, 0), Eigen::Vector3d(7, -2.5, 1.5));
  }

  testing::BoxWorldView Look(double x_m, double y_m = 0.0) {
    return testing::LookAt(
        world, camera_, testing::UprightCamera({x_m, y_m, 1.9}, 1.5),
        [this](double r) { return 0.005 + sd_per_m2_ * r * r; }, random_);
  }
  RangeView ViewOf(const testing::BoxWorldView& look) const {
    return {.rays = rays_,
            .ranges = look.ranges,
            .picture = look.picture(),
            .map_from_camera = look.map_from_camera};
  }
  const CameraRays& rays() const { return rays_; }
  const DoughnutCamera& camera() const { return camera_; }

  testing::BoxWorld world;

 private:
  DoughnutCamera camera_;
  CameraRays rays_;
  double sd_per_m2_;
  std::mt19937_64 random_;
};

/// All that a map says, voxel for voxel; what is spilled is brought back for it.
inline std::vector<std::pair<VoxelIndex, Voxel>> ContentsOf(VoxelMap& map) {
  for (const TileIndex& tile : map.Tiles()) (void)map.Return(tile).has_value();
  std::vector<std::pair<VoxelIndex, Voxel>> all;
  map.ForEachOccupied({.min_hits = 1, .min_hit_share = 0.0},
                      [&](const OccupiedVoxel& v) { all.emplace_back(v.index, v.voxel); });
  return all;
}

inline bool SameBytes(const Voxel& a, const Voxel& b) {
  return a.moment == b.moment && a.weight == b.weight && a.hits == b.hits &&
         a.see_through == b.see_through && a.colour == b.colour && a.to_viewer == b.to_viewer;
}

inline bool SameContents(const std::vector<std::pair<VoxelIndex, Voxel>>& a,
                         const std::vector<std::pair<VoxelIndex, Voxel>>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& p, const auto& q) {
    return p.first == q.first && SameBytes(p.second, q.second);
  });
}

}  // namespace kawara::vision
