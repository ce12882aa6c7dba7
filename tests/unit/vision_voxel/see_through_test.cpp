// What VoxelMap::Examine tells each voxel, against the rule of its header asked of one voxel after
// the other, in doubles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "tests/unit/vision_voxel/voxel_test_support.hpp"

namespace kawara::vision {
namespace {

/// Rays through a voxel, or nothing where rounding may decide it either way.
class Rule {
 public:
  Rule(const RangeView& view, const VoxelMapConfig& config) : view_(view), config_(config) {}

  std::optional<int> RaysThrough(const Eigen::Vector3d& centroid_m) const {
    const Eigen::Vector3d at = view_.map_from_camera.inverse() * centroid_m;
    const double distance_m = at.norm();
    if (std::abs(distance_m - config_.max_range_m) < kTie ||
        std::abs(distance_m - config_.voxel_m) < kTie)
      return {};
    if (distance_m > config_.max_range_m || distance_m < config_.voxel_m) return 0;
    const std::int32_t pixel = view_.rays.PixelOf(at.cast<float>());
    for (int axis = 0; axis < 3; ++axis) {
      for (const double step : {-kTie, kTie}) {
        const Eigen::Vector3d beside = at + step * Eigen::Vector3d::Unit(axis);
        if (view_.rays.PixelOf(beside.cast<float>()) != pixel) return {};
      }
    }
    if (pixel == CameraRays::kNoPixel || std::isnan(Range(pixel))) return 0;
    double least = Excess(pixel, distance_m);
    const int width = view_.ranges.width_px, u = pixel % width, v = pixel / width;
    for (int vv = std::max(0, v - 1); vv <= std::min(view_.ranges.height_px - 1, v + 1); ++vv) {
      for (int uu = std::max(0, u - 1); uu <= std::min(width - 1, u + 1); ++uu) {
        const std::int32_t beside = vv * width + uu;
        if (!std::isnan(Range(beside))) least = std::min(least, Excess(beside, distance_m));
      }
    }
    if (std::abs(least) < kTie) return {};
    if (least < 0.0) return 0;
    const double rays = std::pow(config_.voxel_m / distance_m, 2) *
                        static_cast<double>(view_.rays.PixelsPerSteradian(pixel));
    if (std::abs(rays - std::round(rays)) < kTie) return {};
    return std::clamp(static_cast<int>(rays), 1, 0x7FFF);
  }

 private:
  static constexpr double kTie = 1e-3;

  double Range(std::int32_t pixel) const {
    return static_cast<double>(view_.ranges.range_m[static_cast<std::size_t>(pixel)]);
  }
  /// Metres by which a range exceeds what it must, to have gone through; below zero: it has not.
  double Excess(std::int32_t pixel, double distance_m) const {
    const auto sd = static_cast<double>(view_.ranges.sd_m[static_cast<std::size_t>(pixel)]);
    const double all = std::hypot(sd, view_.position_sd_m, view_.attitude_sd_rad * distance_m);
    return Range(pixel) - distance_m - 0.5 * std::sqrt(3.0) * config_.voxel_m -
           config_.see_through_sigmas * all;
  }

  const RangeView& view_;
  const VoxelMapConfig& config_;
};

TEST(SeeThrough, EveryVoxelIsToldWhatTheRuleSaysOfItAlone) {
  StreetDrive drive(0.008);
  auto map = VoxelMap::Create({.voxel_m = 0.2, .max_range_m = 7.0});
  ASSERT_TRUE(map);
  // A car that is no longer there when it is examined, and noise of ranges all about.
  drive.world.boxes.emplace_back(Eigen::Vector3d(-1, 1.5, 0), Eigen::Vector3d(2, 3, 1.4));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(map->Vote(drive.ViewOf(drive.Look(0.4 * i))));
  drive.world.boxes.pop_back();

  std::size_t compared = 0, through = 0, ties = 0;
  for (int i = 3; i < 6; ++i) {
    const auto look = drive.Look(0.4 * i);
    const RangeView view = drive.ViewOf(look);
    const auto before = ContentsOf(*map);
    const std::uint64_t told = map->counts().seen_through;
    ASSERT_TRUE(map->Examine(view));
    const auto after = ContentsOf(*map);
    ASSERT_EQ(before.size(), after.size());
    const Rule rule(view, map->config());
    std::uint64_t changed = 0;
    for (std::size_t k = 0; k < before.size(); ++k) {
      ASSERT_EQ(before[k].first, after[k].first);
      const int rays = after[k].second.see_through - before[k].second.see_through;
      Voxel rest = after[k].second;
      rest.see_through = before[k].second.see_through;
      EXPECT_TRUE(SameBytes(rest, before[k].second));
      changed += rays != 0 ? 1U : 0U;
      const auto expected = rule.RaysThrough(CentroidVoxels(before[k].first, before[k].second) *
                                             map->config().voxel_m);
      if (!expected) {
        ++ties;
        continue;
      }
      EXPECT_EQ(rays, *expected);
      ++compared;
      through += *expected > 0 ? 1U : 0U;
    }
    EXPECT_EQ(map->counts().seen_through - told, changed);
  }
  EXPECT_GT(compared, 10000U);
  EXPECT_GT(through, 500U);
  EXPECT_LT(ties, compared / 5);
}

}  // namespace
}  // namespace kawara::vision
