#include "sim/render/range_scan.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/sim_render/test_scenes.hpp"

namespace kawara::sim {
namespace {

using Eigen::Vector3d;

RangeScannerSettings Perfect() {
  RangeScannerSettings settings;
  settings.noise_m = settings.noise_share = settings.resolution_m = settings.dropout_share = 0.0;
  settings.beam_rays = 1;
  settings.echo_at_1m = 1e9;
  return settings;
}

std::function<Eigen::Isometry3d(double)> At(const Vector3d& place) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = place;
  return [pose](double) { return pose; };
}

/// A wall 5 m ahead (north), wide and high.
RayScene Wall(Pattern pattern = Pattern::kPlain, float reflectance = 0.5F) {
  Scene scene;
  AddBox(scene, {-200, 5, -5}, {200, 6, 20}, 1,
         AddMaterial(scene, pattern, {reflectance, reflectance, reflectance}));
  return *RayScene::Create(scene);
}

TEST(RangeScanner, APls101Has361BeamsFromRightOverAheadToLeft) {
  const RangeScanner scanner(Perfect());
  const auto beams = scanner.Scan(Wall(), At({0, 0, 1}), 0.0, 1);
  ASSERT_EQ(beams.size(), 361U);
  EXPECT_NEAR(beams[0].angle_rad, 0.0, 1e-12);
  EXPECT_NEAR(beams[180].angle_rad, core::kPi / 2, 1e-12);
  EXPECT_NEAR(beams[360].angle_rad, core::kPi, 1e-12);
  EXPECT_NEAR(beams[180].time_s, 0.0, 1e-12);
  EXPECT_NEAR(beams[360].time_s - beams[0].time_s, 0.020, 1e-12);
}

TEST(RangeScanner, AWallIsMetAtItsRangeInEveryDirection) {
  const auto beams = RangeScanner(Perfect()).Scan(Wall(), At({0, 0, 1}), 0.0, 1);
  for (const RangeBeam& beam : beams) {
    const double range = 5.0 / std::sin(beam.angle_rad);
    if (range < 45.0) {
      EXPECT_TRUE(beam.echo);
      EXPECT_NEAR(beam.range_m, range, 1e-5);
      EXPECT_NEAR(beam.true_range_m, range, 1e-5);
      EXPECT_EQ(beam.object, 1U);
    } else if (range > 51.0) {
      EXPECT_FALSE(beam.echo);
      EXPECT_DOUBLE_EQ(beam.range_m, 50.0);
    }
  }
}

TEST(RangeScanner, TheVehicleMovesWhileTheMirrorTurns) {
  const auto driving = [](double t) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = Vector3d(0, 2.0 * t, 1);  // 2 m/s towards the wall
    return pose;
  };
  const auto beams = RangeScanner(Perfect()).Scan(Wall(), driving, 0.0, 1);
  for (const std::size_t i : {60U, 180U, 300U}) {
    EXPECT_NEAR(beams[i].range_m * std::sin(beams[i].angle_rad), 5.0 - 2.0 * beams[i].time_s, 1e-5);
  }
  EXPECT_LT(beams[300].range_m, beams[60].range_m - 0.02);
}

TEST(RangeScanner, NoiseHasItsSizeAndRangesComeInSteps) {
  RangeScannerSettings settings = Perfect();
  settings.noise_m = 0.03;
  settings.resolution_m = 0.01;
  const RangeScanner scanner(settings);
  const RayScene wall = Wall();
  double sum = 0.0;
  double squares = 0.0;
  int count = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const auto beams = scanner.Scan(wall, At({0, 0, 1}), 0.0, seed);
    for (std::size_t i = 90; i <= 270; ++i) {
      const double error = beams[i].range_m - beams[i].true_range_m;
      sum += error;
      squares += error * error;
      ++count;
      EXPECT_NEAR(beams[i].range_m * 100.0, std::round(beams[i].range_m * 100.0), 1e-6);
    }
  }
  EXPECT_NEAR(sum / count, 0.0, 0.002);
  EXPECT_NEAR(std::sqrt(squares / count), std::hypot(0.03, 0.01 / std::sqrt(12.0)), 0.001);
}

TEST(RangeScanner, TheSameSeedIsTheSameSweep) {
  const RangeScanner scanner{RangeScannerSettings()};
  const RayScene wall = Wall();
  const auto ranges = [&](std::uint64_t seed) {
    std::vector<double> out;
    for (const RangeBeam& beam : scanner.Scan(wall, At({0, 0, 1}), 0.0, seed))
      out.push_back(beam.range_m);
    return out;
  };
  EXPECT_EQ(ranges(3), ranges(3));
  EXPECT_NE(ranges(3), ranges(4));
}

TEST(RangeScanner, DarkAndGrazingSurfacesAreSeenLessFar) {
  RangeScannerSettings settings;
  settings.noise_m = settings.dropout_share = 0.0;
  const RangeScanner scanner(settings);
  const auto seen = [&](float reflectance) {
    int count = 0;
    for (const auto& beam :
         scanner.Scan(Wall(Pattern::kPlain, reflectance), At({0, -10, 1}), 0.0, 1))
      count += beam.echo ? 1 : 0;
    return count;
  };
  EXPECT_GT(seen(0.6F), 200);
  EXPECT_LT(seen(0.02F), 0.8 * seen(0.6F));
}

TEST(RangeScanner, GlassIsSeenOnlySquareOn) {
  RangeScannerSettings settings;
  settings.noise_m = settings.dropout_share = 0.0;
  const auto beams = RangeScanner(settings).Scan(Wall(Pattern::kGlass), At({0, -15, 1}), 0.0, 1);
  EXPECT_TRUE(beams[180].echo);
  EXPECT_FALSE(beams[140].echo);
  EXPECT_FALSE(beams[220].echo);
}

TEST(RangeScanner, ABeamThatMeetsTwoSurfacesTellsOneOfThemOrBetween) {
  Scene scene;
  AddBox(scene, {0, 5, -5}, {20, 6, 20}, 1, AddMaterial(scene));  // right half near
  AddBox(scene, {-20, 5.3, -5}, {20, 6.5, 20}, 2, 0);             // behind it, 0.3 m further
  RangeScannerSettings settings = Perfect();
  settings.beam_rays = 7;
  const auto beams = RangeScanner(settings).Scan(*RayScene::Create(scene), At({0, 0, 1}), 0.0, 1);
  EXPECT_NEAR(beams[170].range_m, 5.0 / std::sin(beams[170].angle_rad), 0.01);
  EXPECT_NEAR(beams[190].range_m, 5.3 / std::sin(beams[190].angle_rad), 0.01);
  EXPECT_GT(beams[180].range_m, 5.02);
  EXPECT_LT(beams[180].range_m, 5.28);
}

TEST(RangeScanner, SomeBeamsAreLostForNoReason) {
  RangeScannerSettings settings = Perfect();
  settings.dropout_share = 0.1;
  int lost = 0;
  int count = 0;
  const RayScene wall = Wall();
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const auto beams = RangeScanner(settings).Scan(wall, At({0, 0, 1}), 0.0, seed);
    for (std::size_t i = 90; i <= 270; ++i, ++count) lost += beams[i].echo ? 0 : 1;
  }
  EXPECT_NEAR(static_cast<double>(lost) / count, 0.1, 0.015);
}

}  // namespace
}  // namespace kawara::sim
