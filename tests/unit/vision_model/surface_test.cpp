#include "vision/model/surface.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <set>

#include "tests/unit/vision_voxel/voxel_test_support.hpp"

namespace kawara::vision {
namespace {

constexpr OccupancyRule kRule{.min_hits = 10};

struct Fit {
  double rms_m = 0.0, worst_m = 0.0;
  int n = 0;
  void Add(double d) {
    rms_m = std::sqrt((rms_m * rms_m * n + d * d) / (n + 1));
    worst_m = std::max(worst_m, d);
    ++n;
  }
};

Eigen::Vector3d Corner(const core::TexturedMesh& mesh, std::uint32_t i) {
  const auto& p = mesh.positions_m[i];
  return mesh.offset_m + Eigen::Vector3f(p[0], p[1], p[2]).cast<double>();
}

class StreetSurface : public ::testing::Test {
 protected:
  void Drive(double voxel_m, double sd_per_m2) {
    StreetDrive drive(sd_per_m2);
    map_ = *VoxelMap::Create({.voxel_m = voxel_m, .max_range_m = 5.5});
    for (int i = 0; i < 24; ++i) {
      const auto look = drive.Look(0.25 * i);
      ASSERT_TRUE(map_->Vote(drive.ViewOf(look)));
      ASSERT_TRUE(map_->Examine(drive.ViewOf(look)));
    }
    world_ = drive.world;
  }
  std::optional<VoxelMap> map_;
  testing::BoxWorld world_;
};

TEST_F(StreetSurface, LiesNearerToTheTruthThanVoxelsAndVotes) {
  Drive(0.1, 0.004);
  Fit surface, voxels;
  for (const TileIndex& tile : map_->Tiles()) {
    const Surface s = BuildSurface(*map_, tile, {kRule});
    for (std::uint32_t i = 0; i < s.mesh.positions_m.size(); ++i)
      surface.Add(world_.DistanceToSurface(Corner(s.mesh, i)));
  }
  map_->ForEachOccupied(kRule, [&](const OccupiedVoxel& v) {
    voxels.Add(world_.DistanceToSurface(CentroidVoxels(v.index, v.voxel) * 0.1));
  });
  ASSERT_GT(surface.n, 3000);
  RecordProperty("surface_mm", static_cast<int>(surface.rms_m * 1000));
  RecordProperty("voxels_mm", static_cast<int>(voxels.rms_m * 1000));
  // One vote is wrong by 15 mm next to the robot and by 120 mm at the wall's far ends.
  EXPECT_LT(surface.rms_m, 0.030);
  EXPECT_LT(surface.rms_m, 0.6 * voxels.rms_m);
}

TEST_F(StreetSurface, TrianglesFaceTheViewer) {
  Drive(0.1, 0.002);
  double area_right = 0.0, area = 0.0;
  for (const TileIndex& tile : map_->Tiles()) {
    const Surface s = BuildSurface(*map_, tile, {kRule});
    for (const auto& t : s.mesh.triangles) {
      const Eigen::Vector3d a = Corner(s.mesh, t[0]), b = Corner(s.mesh, t[1]),
                            c = Corner(s.mesh, t[2]);
      const Eigen::Vector3d twice = (b - a).cross(c - a);
      area += twice.norm();
      if (twice.dot(Eigen::Vector3d(3, 0, 1.9) - a) > 0.0) area_right += twice.norm();
    }
  }
  ASSERT_GT(area, 50.0);
  EXPECT_GT(area_right, 0.97 * area);
}

TEST_F(StreetSurface, TilesMeetWithoutAGapAndUnknownStaysOpen) {
  Drive(0.1, 0.001);
  // Edges of quads within a tile that have one quad only: rims, and where tiles meet.
  std::vector<Eigen::Vector3d> rims;
  double far_m = 0.0;
  for (const TileIndex& tile : map_->Tiles()) {
    const Surface s = BuildSurface(*map_, tile, {kRule});
    std::map<std::set<std::uint32_t>, int> edges;
    for (const Quad& q : s.quads)
      for (std::size_t i = 0; i < 4; ++i) ++edges[{q[i], q[(i + 1) % 4]}];
    for (const auto& [edge, count] : edges)
      if (count == 1)
        rims.push_back((Corner(s.mesh, *edge.begin()) + Corner(s.mesh, *edge.rbegin())) / 2);
    for (std::uint32_t i = 0; i < s.mesh.positions_m.size(); ++i)
      far_m = std::max(far_m, world_.DistanceToSurface(Corner(s.mesh, i)));
  }
  // The ground along y = 0 is seen from everywhere, and y = 0 is a border of tiles: each rim there
  // must be a rim of the neighbour as well.
  int on_seam = 0;
  for (std::size_t i = 0; i < rims.size(); ++i) {
    const Eigen::Vector3d& p = rims[i];
    if (std::abs(p.y()) > 0.15 || p.x() < 1.0 || p.x() > 5.0 || std::abs(p.z()) > 0.2) continue;
    ++on_seam;
    double nearest_m = 1.0;
    for (std::size_t k = 0; k < rims.size(); ++k)
      if (k != i) nearest_m = std::min(nearest_m, (rims[k] - p).norm());
    EXPECT_LT(nearest_m, 1e-5);
  }
  EXPECT_GT(on_seam, 60);
  EXPECT_LT(far_m, 0.25);  // nothing bridges from the ground to the car's roof nor closes the sky
}

TEST_F(StreetSurface, BlockyFacesAreThoseOfTheVoxels) {
  Drive(0.2, 0.002);
  std::size_t faces = 0;
  for (const TileIndex& tile : map_->Tiles())
    faces += BuildSurface(*map_, tile, {kRule}, SurfaceKind::kBlocky).quads.size();
  std::set<VoxelIndex> occupied;
  map_->ForEachOccupied(kRule, [&](const OccupiedVoxel& v) { occupied.insert(v.index); });
  std::size_t expected = 0;
  for (const VoxelIndex& v : occupied) {
    for (const int d : {-1, 1}) {
      expected += occupied.contains({v.x + d, v.y, v.z}) ? 0U : 1U;
      expected += occupied.contains({v.x, v.y + d, v.z}) ? 0U : 1U;
      expected += occupied.contains({v.x, v.y, v.z + d}) ? 0U : 1U;
    }
  }
  EXPECT_GT(faces, 1000U);
  EXPECT_EQ(faces, expected);
}

constexpr OccupancyRule kFive{.min_hits = 5};

/// So many votes in the middle of a voxel.
void Hit(VoxelMap& map, int x, int y, int z, int hits) {
  const PointVote vote{.position_m = 0.1 * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5),
                       .to_viewer = Eigen::Vector3f::UnitZ(),
                       .sd_m = 0.02F};
  const std::vector<PointVote> votes(static_cast<std::size_t>(hits), vote);
  ASSERT_TRUE(map.Vote(votes));
}

TEST(Surface, ScrapsOfFewVotesAreNotPartOfIt) {
  auto map = VoxelMap::Create({.voxel_m = 0.1});
  for (int x = 10; x < 20; ++x) {
    for (int y = 10; y < 20; ++y) Hit(*map, x, y, 5, 40);
    Hit(*map, x, 20, 5, 6);  // seen less, but it goes on: is surface
    Hit(*map, x, 21, 5, 6);  // touches none that stands by itself
  }
  for (int x = 40; x < 44; ++x) {
    for (int y = 40; y < 44; ++y) Hit(*map, x, y, 5, 6);  // one picture said so
  }
  for (int z = 20; z < 23; ++z) Hit(*map, 30, 30, z, 60);  // in the middle of nowhere
  const auto points = [&](const SurfaceRule& rule) {
    return BuildSurface(*map, {0, 0}, rule).points.size();
  };
  EXPECT_EQ(points({kFive}), 100U + 20U + 16U + 3U);
  EXPECT_EQ(points({kFive, 20}), 100U + 10U + 3U);
  EXPECT_EQ(points({kFive, 20, 8}), 100U + 10U);
  const Surface surface = BuildSurface(*map, {0, 0}, {kFive, 20, 8});
  for (std::uint32_t i = 0; i < surface.mesh.positions_m.size(); ++i) {
    EXPECT_NEAR(Corner(surface.mesh, i).z(), 0.55, 0.01);
  }
  EXPECT_EQ(surface.points.front().votes, 40U);
}

TEST(Surface, OfNothingIsNothing) {
  const auto map = VoxelMap::Create({});
  EXPECT_TRUE(BuildSurface(*map, {0, 0}, {}).quads.empty());
}

}  // namespace
}  // namespace kawara::vision
