#include "vision/voxel/voxel_map.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "tests/unit/vision_voxel/voxel_test_support.hpp"

namespace kawara::vision {
namespace {

constexpr OccupancyRule kAnyHit{.min_hits = 1, .min_hit_share = 0.0};

TEST(VoxelMap, OccupiesWhatADenseArrayInDoublesDoes) {
  StreetDrive drive(0.008);
  const VoxelMapConfig config{.voxel_m = 0.25, .max_range_m = 7.0, .max_sd_m = 0.3};
  auto map = VoxelMap::Create(config);
  ASSERT_TRUE(map);
  std::map<std::array<int, 3>, int> dense;
  int on_borders = 0;
  for (int i = 0; i < 5; ++i) {
    // Far from the origin, where floats of map coordinates would no longer do.
    auto look = drive.Look(0.7 * i);
    look.map_from_camera.pretranslate(Eigen::Vector3d(90000.0, -70000.0, 100.0));
    const RangeView view = drive.ViewOf(look);
    ASSERT_TRUE(map->Vote(view));
    for (std::size_t p = 0; p < view.rays.pixels(); ++p) {
      const double r = static_cast<double>(look.ranges.range_m[p]);
      const double sd = std::hypot(static_cast<double>(look.ranges.sd_m[p]), view.position_sd_m,
                                   view.attitude_sd_rad * r);
      if (!(r >= config.min_range_m && r <= config.max_range_m && sd <= config.max_sd_m)) continue;
      const Eigen::Vector3d ray = view.rays.ray(p).cast<double>();
      const Eigen::Vector3d at = look.map_from_camera * Eigen::Vector3d(ray * r) / config.voxel_m;
      const Eigen::Array3d nearest = at.array().round();
      // A thousandth of a voxel from a border, floats may fall to either side.
      if ((at.array() - nearest).abs().minCoeff() < 1e-3) {
        ++on_borders;
        continue;
      }
      const Eigen::Array3d index = at.array().floor();
      ++dense[{static_cast<int>(index.x()), static_cast<int>(index.y()),
               static_cast<int>(index.z())}];
    }
  }
  std::uint64_t votes = 0, here = 0;
  for (const auto& [index, hits] : dense) {
    const Voxel* v = map->Find({index[0], index[1], index[2]});
    ASSERT_NE(v, nullptr);
    EXPECT_GE(v->hits, hits);
    votes += static_cast<std::uint64_t>(hits);
  }
  std::size_t extra = 0;
  map->ForEachOccupied(kAnyHit, [&](const OccupiedVoxel& v) {
    here += v.voxel.hits;
    extra += dense.contains({v.index.x, v.index.y, v.index.z}) ? 0U : 1U;
  });
  EXPECT_GT(dense.size(), 3000U);
  EXPECT_EQ(here, votes + static_cast<std::uint64_t>(on_borders));
  EXPECT_EQ(here, map->counts().votes);
  EXPECT_LE(extra, static_cast<std::size_t>(on_borders));
  EXPECT_GT(map->counts().dropped_far, 0U);
  EXPECT_GT(map->counts().dropped_uncertain, 0U);
}

TEST(VoxelMap, CentroidIsTheMeanWeightedByInverseVariance) {
  StreetDrive drive(0.002);
  const VoxelMapConfig config{.voxel_m = 0.5};
  auto map = VoxelMap::Create(config);
  struct Sum {
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    double weight = 0.0;
  };
  std::map<std::array<int, 3>, Sum> dense;
  for (int i = 0; i < 4; ++i) {
    const auto look = drive.Look(0.9 * i);
    const RangeView view = drive.ViewOf(look);
    ASSERT_TRUE(map->Vote(view));
    for (std::size_t p = 0; p < view.rays.pixels(); ++p) {
      const double r = static_cast<double>(look.ranges.range_m[p]);
      if (!(r >= config.min_range_m && r <= config.max_range_m)) continue;
      const Eigen::Vector3d at =
          look.map_from_camera * Eigen::Vector3d(view.rays.ray(p).cast<double>() * r);
      const Eigen::Array3d index = (at.array() / config.voxel_m).floor();
      const double sd = static_cast<double>(look.ranges.sd_m[p]);
      const double w = 1.0 / (sd * sd + view.position_sd_m * view.position_sd_m +
                              view.attitude_sd_rad * view.attitude_sd_rad * r * r);
      auto& sum = dense[{static_cast<int>(index.x()), static_cast<int>(index.y()),
                         static_cast<int>(index.z())}];
      sum.moment += w * at;
      sum.weight += w;
    }
  }
  int compared = 0;
  map->ForEachOccupied({.min_hits = 60}, [&](const OccupiedVoxel& v) {
    const auto found = dense.find({v.index.x, v.index.y, v.index.z});
    ASSERT_NE(found, dense.end());
    const Eigen::Vector3d truth = found->second.moment / found->second.weight;
    // A vote within rounding of a border may count on either side of it.
    EXPECT_LT((CentroidVoxels(v.index, v.voxel) * config.voxel_m - truth).norm(), 0.002);
    EXPECT_NEAR(static_cast<double>(v.voxel.weight) / found->second.weight, 1.0, 0.02);
    ++compared;
  });
  EXPECT_GT(compared, 300);
}

TEST(VoxelMap, CentroidsLieNearerToTheSurfaceThanOneVote) {
  StreetDrive drive(0.004);
  auto map = VoxelMap::Create({.voxel_m = 0.2, .max_range_m = 6.0});
  for (int i = 0; i < 12; ++i) ASSERT_TRUE(map->Vote(drive.ViewOf(drive.Look(0.25 * i))));
  double sum2 = 0.0;
  int n = 0;
  // Voxels that the ground crosses in the middle catch nearly all of its votes.
  map->ForEachOccupied({.min_hits = 100}, [&](const OccupiedVoxel& v) {
    const Eigen::Vector3d c = CentroidVoxels(v.index, v.voxel) * 0.2;
    if (c.y() > 3.5 || c.z() > 0.15) return;
    sum2 += std::pow(drive.world.DistanceToSurface(c), 2);
    ++n;
  });
  ASSERT_GT(n, 100);
  // One vote at the least range there (1.9 m) has 19 mm; those of a voxel are half on each side of
  // a border at z = 0, which moves a half's centroid by 0.8 of that: no nearer can a voxel come.
  EXPECT_LT(std::sqrt(sum2 / n), 0.045);
}

TEST(VoxelMap, ColourAndViewAreThoseOfTheVotes) {
  StreetDrive drive(0.0);
  auto map = VoxelMap::Create({.voxel_m = 0.1});
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(map->Vote(drive.ViewOf(drive.Look(0.1 * i))));
  int compared = 0;
  map->ForEachOccupied({.min_hits = 8}, [&](const OccupiedVoxel& v) {
    const Eigen::Vector3d c = CentroidVoxels(v.index, v.voxel) * 0.1;
    const auto truth = testing::BoxWorld::Colour(c);
    const auto rgb = ColourOf(v.voxel);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(rgb[k], truth[k], 12);
    const Eigen::Vector3d view =
        Eigen::Vector3d(v.voxel.to_viewer[0], v.voxel.to_viewer[1], v.voxel.to_viewer[2]) /
        double{Voxel::kViewOne};
    const Eigen::Vector3d to_camera = (Eigen::Vector3d(0.25, 0.0, 1.9) - c).normalized();
    EXPECT_GT(view.dot(to_camera), 0.97);
    ++compared;
  });
  EXPECT_GT(compared, 100);
}

TEST(VoxelMap, SeeThroughTakesAGhostAwayAndLeavesSurfaces) {
  StreetDrive drive(0.002);
  auto map = VoxelMap::Create({.voxel_m = 0.2});
  // A car that drives off: seen in four pictures, gone in the next ones.
  drive.world.boxes.emplace_back(Eigen::Vector3d(-1, 1.5, 0), Eigen::Vector3d(2, 3, 1.4));
  const auto ghost_box = drive.world.boxes.back();
  for (int i = 0; i < 4; ++i) {
    const auto look = drive.Look(0.2 * i);
    ASSERT_TRUE(map->Vote(drive.ViewOf(look)));
    ASSERT_TRUE(map->Examine(drive.ViewOf(look)));
  }
  drive.world.boxes.pop_back();
  const auto count = [&](const OccupancyRule& rule) {
    std::array<int, 2> ghost_and_real{};
    map->ForEachOccupied(rule, [&](const OccupiedVoxel& v) {
      const Eigen::Vector3d c = CentroidVoxels(v.index, v.voxel) * 0.2;
      if (c.z() < 0.3) return;
      const bool ghost = ghost_box.exteriorDistance(c) < 0.15;
      if (ghost || drive.world.DistanceToSurface(c) < 0.1) ++ghost_and_real[ghost ? 0 : 1];
    });
    return ghost_and_real;
  };
  const auto before = count({});
  for (int i = 4; i < 14; ++i) {
    const auto look = drive.Look(0.2 * i);
    ASSERT_TRUE(map->Vote(drive.ViewOf(look)));
    ASSERT_TRUE(map->Examine(drive.ViewOf(look)));
  }
  const auto after = count({}), voted = count({.min_hit_share = 0.0});
  ASSERT_GT(before[0], 50);
  EXPECT_LE(after[0], before[0] / 50);
  EXPECT_GT(after[1], before[1]);
  EXPECT_GE(after[1], voted[1] * 99 / 100);  // no surface is eaten
}

TEST(VoxelMap, SameInputMakesSameBytes) {
  std::array<std::vector<std::pair<VoxelIndex, Voxel>>, 2> results;
  for (auto& result : results) {
    StreetDrive drive(0.004);
    auto map = VoxelMap::Create({});
    for (int i = 0; i < 3; ++i) {
      const auto look = drive.Look(0.5 * i);
      ASSERT_TRUE(map->Vote(drive.ViewOf(look)));
      ASSERT_TRUE(map->Examine(drive.ViewOf(look)));
    }
    result = ContentsOf(*map);
  }
  EXPECT_GT(results[0].size(), 1000U);
  EXPECT_TRUE(SameContents(results[0], results[1]));
}

TEST(VoxelMap, CountersNeverWrapAround) {
  StreetDrive drive(0.0, 128);
  auto map = VoxelMap::Create({.voxel_m = 5.0});
  const auto look = drive.Look(0.0);
  for (int i = 0; i < 60; ++i) ASSERT_TRUE(map->Vote(drive.ViewOf(look)));
  int most = 0;
  map->ForEachOccupied({.min_hits = 1, .min_hit_share = 0.0}, [&](const OccupiedVoxel& v) {
    most = std::max<int>(most, v.voxel.hits);
    for (const float m : v.voxel.moment) EXPECT_LE(std::abs(m), 0.51F * v.voxel.weight);
  });
  EXPECT_GT(map->counts().votes, 3U * 65536U);
  EXPECT_GT(most, 32767);
}

TEST(VoxelMap, RefusesWhatCannotBe) {
  EXPECT_FALSE(VoxelMap::Create({.voxel_m = 0.0}));
  EXPECT_FALSE(VoxelMap::Create({.voxel_m = 0.01, .max_range_m = 9.0}));
  EXPECT_FALSE(VoxelMap::Create({.min_range_m = 9.0}));
  EXPECT_FALSE(VoxelMap::Create({.max_sd_m = 0.0}));
  StreetDrive drive(0.0, 128);
  auto map = VoxelMap::Create({});
  const auto look = drive.Look(0.0);
  auto bad_pose = look;
  bad_pose.map_from_camera.translation().x() = std::nan("");
  EXPECT_FALSE(map->Vote(drive.ViewOf(bad_pose)));
  bad_pose.map_from_camera.translation().x() = 1e9;
  EXPECT_FALSE(map->Vote(drive.ViewOf(bad_pose)));
  auto small = look;
  small.ranges.Reset(10, 10);
  small.pixels.resize(300);
  EXPECT_FALSE(map->Examine(drive.ViewOf(small)));
  EXPECT_EQ(map->counts().votes, 0U);
}

}  // namespace
}  // namespace kawara::vision
