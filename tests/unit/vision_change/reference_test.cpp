#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/vision_change/street.hpp"
#include "vision/change/align_reference.hpp"
#include "vision/change/reference_file.hpp"

namespace kawara::vision {
namespace {

using test_support::Street;

ReferenceMap Before() {
  Street street(7, 0.02);
  street.AddGround();
  street.AddWalls();
  ReferenceMap map = street.Reference();
  map.origin = core::Geodetic{0.6, 2.4, 40.0};
  map.roads.push_back(
      {"road", {{-20, -4}, {20, -4}, {20, 4}, {-20, 4}}, {{{0, 0}, {1, 0}, {1, 1}}}});
  map.road_axes.emplace_back("middle", std::vector<Eigen::Vector2d>{{-20, 0}, {20, 0}});
  return map;
}

TEST(ReferenceBuilder, PlanesLieWhereTheWallStands) {
  const ReferenceMap map = Before();
  for (double x = -15; x < 15; x += 1.3) {
    const auto match = map.Nearest({x, 5.9, 2.2}, 0.5);
    ASSERT_TRUE(match);
    EXPECT_NEAR(match->distance_m, 0.1, 0.03);
    EXPECT_GT(std::abs(match->normal.y()), 0.95);
    EXPECT_LT(match->sd_m, 0.05);
  }
  EXPECT_FALSE(map.Nearest({0, 0, 2.0}, 0.5));
}

TEST(ReferenceBuilder, GroundIsTheRoadAndNotTheWalls) {
  const ReferenceMap map = Before();
  for (double y = -5; y <= 5; y += 1.1) {
    const auto up = map.ground.At({0.0, y});
    ASSERT_TRUE(up);
    EXPECT_NEAR(up->up_m, 0.0, 0.03);
  }
}

TEST(ReferenceBuilder, AFaceWithAHoleHasItsHole) {
  ReferenceBuilder builder;
  builder.Begin({"wall", "city model", {}, 0.1});
  builder.AddFace({{{0, 0, 0}, {10, 0, 0}, {10, 0, 6}, {0, 0, 6}},
                   {{4, 0, 2}, {6, 0, 2}, {6, 0, 4}, {4, 0, 4}}});
  const ReferenceMap map = builder.Finish(false);
  EXPECT_TRUE(map.Nearest({2.0, 0.05, 3.0}, 0.2));
  EXPECT_FALSE(map.Nearest({5.0, 0.05, 3.0}, 0.2));
  EXPECT_NEAR(map.Nearest({8.0, 0.05, 5.0}, 0.2)->sd_m, 0.1, 0.01);
}

TEST(ReferenceFile, ComesBackAsItWas) {
  const ReferenceMap map = Before();
  const auto bytes = EncodeReference(map);
  const auto back = DecodeReference(bytes);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(EncodeReference(*back), bytes);
  EXPECT_EQ(back->patches(), map.patches());
  EXPECT_EQ(back->sources.at(0).name, "street");
  EXPECT_EQ(back->Date().ns(), 1);
  EXPECT_EQ(back->roads.at(0).holes.at(0).size(), 3U);
}

TEST(ReferenceFile, EveryDamageIsNoticed) {
  const auto bytes = EncodeReference(Before());
  for (std::size_t i = 0; i < bytes.size(); i += 1 + bytes.size() / 200) {
    auto damaged = bytes;
    damaged[i] ^= 0x10U;
    EXPECT_FALSE(DecodeReference(damaged)) << i;
    EXPECT_FALSE(DecodeReference(std::span(bytes).first(i))) << i;
  }
}

TEST(AlignReference, FindsASmallShiftAndRefusesALargeOne) {
  const ReferenceMap reference = Before();
  Street street(9, 0.03);
  street.AddGround();
  street.AddWalls();
  // A wall across, so that the shift along the road shows.
  street.AddBox({{10.0, 5.0, 1.0}, {0.4, 1.5, 2.0}, 0.0});
  const auto shifted = [&](const Eigen::Vector3d& by) {
    auto map = *VoxelMap::Create({.voxel_m = 0.2});
    std::vector<PointVote> votes;
    for (Eigen::Vector3d p : street.Points()) {
      PointVote vote;
      vote.position_m = p + by;
      votes.push_back(vote);
    }
    EXPECT_TRUE(map.Vote(votes));
    return AlignReference(map, {reference, Street::Road(), {}},
                          {.min_hits = 1, .min_hit_share = 0.0}, {});
  };
  const auto small = shifted({0.0, 0.10, -0.05});
  ASSERT_TRUE(small) << small.error().message;
  EXPECT_NEAR(small->shift_m.y(), -0.10, 0.02);
  EXPECT_NEAR(small->shift_m.z(), 0.05, 0.02);
  EXPECT_LT(small->residual_m, small->residual_before_m);
  const auto none = shifted({0.0, 0.0, 0.0});
  ASSERT_TRUE(none);
  EXPECT_LT(none->shift_m.norm(), 0.03);
  const auto large = shifted({0.0, 0.5, 0.0});
  ASSERT_FALSE(large);
  EXPECT_NE(large.error().message.find("beyond reason"), std::string::npos);
}

/// Ground, and four posts at the side of the road: as much as a wide road has near.
Street Posts(unsigned seed, bool posts) {
  Street street(seed, 0.03);
  street.AddGround();
  for (const double x : {-9.0, -3.0, 3.0, 9.0})
    if (posts) street.AddBox({{x, 4.3, 1.0}, {0.24, 0.24, 2.0}, 0.0});
  return street;
}

core::Expected<Alignment> AlignPosts(bool posts, const Eigen::Vector3d& by) {
  ReferenceMap reference = Posts(7, posts).Reference();
  Street street = Posts(9, posts);
  auto map = *VoxelMap::Create({.voxel_m = 0.2});
  std::vector<PointVote> votes;
  for (const Eigen::Vector3d& p : street.Points()) {
    PointVote vote;
    vote.position_m = p + by;
    votes.push_back(vote);
  }
  EXPECT_TRUE(map.Vote(votes));
  return AlignReference(map, {std::move(reference), Street::Road(), {}},
                        {.min_hits = 1, .min_hit_share = 0.0}, {});
}

TEST(AlignReference, AFewPostsAmongMuchGroundTellHalfAMetre) {
  const auto right = AlignPosts(true, {0.0, 0.0, 0.0});
  ASSERT_TRUE(right) << right.error().message;
  EXPECT_LT(right->shift_m.norm(), 0.05);
  for (const Eigen::Vector3d& by : {Eigen::Vector3d(0.30, 0.40, 0.0), {0.0, -0.5, 0.0}}) {
    const auto off = AlignPosts(true, by);
    ASSERT_FALSE(off) << by.transpose();
    EXPECT_NE(off.error().message.find("beyond reason"), std::string::npos);
  }
}

TEST(AlignReference, SaysWhatNothingUprightTells) {
  const auto level = AlignPosts(false, {0.3, 0.4, 0.0});
  ASSERT_TRUE(level) << level.error().message;
  EXPECT_NEAR(level->shift_sd_m.y(), AlignOptions{}.prior_sd_m, 0.01);
  EXPECT_LT(level->shift_sd_m.z(), 0.03);
  EXPECT_NE(Unchecked(*level).find("in the plane"), std::string::npos);
  Alignment street = *level;
  street.plane_covariance_m2 = Eigen::Vector2d(0.15 * 0.15, 0.02 * 0.02).asDiagonal();
  EXPECT_NE(Unchecked(street).find("90 deg"), std::string::npos);
  street.plane_covariance_m2 *= 0.1;
  EXPECT_TRUE(Unchecked(street).empty());
}

}  // namespace
}  // namespace kawara::vision
