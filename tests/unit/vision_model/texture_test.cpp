#include "vision/model/texture.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/vision_voxel/voxel_test_support.hpp"

namespace kawara::vision {
namespace {

constexpr OccupancyRule kRule{.min_hits = 10};

class TexturedStreet : public ::testing::Test {
 protected:
  void SetUp() override {
    map_ = *VoxelMap::Create({.voxel_m = 0.1, .max_range_m = 4.5});
    for (int i = 0; i < 6; ++i) {
      looks_.push_back(drive_.Look(0.5 * i));
      ASSERT_TRUE(map_->Vote(drive_.ViewOf(looks_.back())));
    }
  }
  std::vector<TextureView> Views() const {
    std::vector<TextureView> views;
    for (const auto& look : looks_)
      views.push_back({.camera = drive_.camera(),
                       .picture = look.picture(),
                       .ranges = &look.ranges,
                       .map_from_camera = look.map_from_camera});
    return views;
  }
  /// Calls visit(texture, truth) for the colours at the middle of each quad.
  template <class Visit>
  void CompareWithPaint(const Surface& s, const Visit& visit) {
    JpegDecoder decoder;
    const auto atlas = decoder.Decode(s.mesh.texture_jpeg);
    ASSERT_TRUE(atlas);
    for (const Quad& q : s.quads) {
      Eigen::Vector3d middle = s.mesh.offset_m;
      Eigen::Vector2d uv(0, 0);
      for (const std::uint32_t i : q) {
        const auto& p = s.mesh.positions_m[i];
        middle += 0.25 * Eigen::Vector3f(p[0], p[1], p[2]).cast<double>();
        uv += 0.25 *
              Eigen::Vector2f(s.mesh.texture_coordinates[i][0], s.mesh.texture_coordinates[i][1])
                  .cast<double>();
      }
      const auto u = static_cast<std::size_t>(uv.x() * atlas->width_px);
      const std::uint8_t* const rgb =
          atlas->row(static_cast<int>(uv.y() * atlas->height_px)) + u * 3;
      const auto truth = testing::BoxWorld::Colour(middle);
      for (std::size_t c = 0; c < 3; ++c)
        visit(static_cast<double>(rgb[c]), static_cast<double>(truth[c]));
    }
  }
  /// Mean error [levels].
  double ErrorOf(const Surface& s) {
    double sum = 0.0;
    CompareWithPaint(s, [&](double rgb, double truth) { sum += std::abs(rgb - truth); });
    return sum / (3.0 * static_cast<double>(s.quads.size()));
  }

  StreetDrive drive_{0.0005};
  std::vector<testing::BoxWorldView> looks_;
  std::optional<VoxelMap> map_;
  JpegEncoder encoder_;
};

TEST_F(TexturedStreet, ShowsThePaintOfTheWorld) {
  Surface s = BuildSurface(*map_, {0, 0}, {kRule});
  const auto counts = ApplyTexture(s, 0.1, Views(), {}, encoder_);
  ASSERT_TRUE(counts) << counts.error().message;
  ASSERT_GT(counts->quads, 500U);
  EXPECT_GT(counts->from_pictures, counts->quads * 95 / 100);
  EXPECT_EQ(s.mesh.texture_coordinates.size(), s.mesh.positions_m.size());
  EXPECT_EQ(s.mesh.triangles.size(), 2 * s.quads.size());
  EXPECT_LT(ErrorOf(s), 8.0);
}

TEST_F(TexturedStreet, BringsExposuresTogether) {
  // Every other picture a third darker.
  for (std::size_t i = 0; i < looks_.size(); i += 2)
    for (auto& p : looks_[i].pixels) p = static_cast<std::uint8_t>(p * 0.67);
  auto map = VoxelMap::Create(map_->config());
  for (const auto& look : looks_) ASSERT_TRUE(map->Vote(drive_.ViewOf(look)));
  Surface s = BuildSurface(*map, {0, 0}, {kRule});
  ASSERT_TRUE(ApplyTexture(s, 0.1, Views(), {}, encoder_));
  // All alike between the two, where the pictures are 0.67 and 1 (a deviation of 0.165).
  double sum = 0.0, sum2 = 0.0;
  int n = 0;
  CompareWithPaint(s, [&](double rgb, double truth) {
    if (truth < 80.0) return;
    sum += rgb / truth;
    sum2 += rgb * rgb / (truth * truth);
    ++n;
  });
  ASSERT_GT(n, 1000);
  EXPECT_LT(std::sqrt(sum2 / n - sum * sum / n / n), 0.09);
}

TEST_F(TexturedStreet, WhatIsHiddenInAPictureIsNotTakenFromIt) {
  // One picture only, with a distance image that says a wall stands half a metre before everything.
  auto look = looks_[2];
  for (float& r : look.ranges.range_m)
    if (!std::isnan(r)) r = 0.6F;
  const RangeImage half = RangesForTexture(look.ranges);
  for (const RangeImage* ranges : std::initializer_list<const RangeImage*>{&look.ranges, &half}) {
    const std::array views{TextureView{.camera = drive_.camera(),
                                       .picture = look.picture(),
                                       .ranges = ranges,
                                       .map_from_camera = look.map_from_camera}};
    Surface s = BuildSurface(*map_, {0, 0}, {kRule});
    const auto counts = ApplyTexture(s, 0.1, views, {}, encoder_);
    ASSERT_TRUE(counts);
    // What has no range in the picture (beyond its ring) is not hidden either.
    EXPECT_LT(counts->from_pictures, counts->quads / 20);
    EXPECT_LT(ErrorOf(s), 12.0);  // the voxels' own colours stand in
  }
}

TEST_F(TexturedStreet, RangesOfHalfTheSizeHideAsMuch) {
  std::vector<RangeImage> halves;
  for (const auto& look : looks_) halves.push_back(RangesForTexture(look.ranges));
  auto views = Views();
  Surface whole = BuildSurface(*map_, {0, 0}, {kRule});
  const auto by_whole = ApplyTexture(whole, 0.1, views, {}, encoder_);
  for (std::size_t i = 0; i < views.size(); ++i) views[i].ranges = &halves[i];
  Surface half = BuildSurface(*map_, {0, 0}, {kRule});
  const auto by_half = ApplyTexture(half, 0.1, views, {}, encoder_);
  ASSERT_TRUE(by_whole && by_half);
  EXPECT_NEAR(static_cast<double>(by_half->from_pictures),
              static_cast<double>(by_whole->from_pictures),
              0.01 * static_cast<double>(by_whole->quads));
  EXPECT_NEAR(ErrorOf(half), ErrorOf(whole), 0.3);
}

TEST_F(TexturedStreet, RangesOfAnotherSizeAreRefused) {
  RangeImage other = looks_[0].ranges;
  other.Reset(other.width_px / 3, other.height_px / 3);
  auto views = Views();
  views[0].ranges = &other;
  Surface s = BuildSurface(*map_, {0, 0}, {kRule});
  EXPECT_FALSE(ApplyTexture(s, 0.1, views, {}, encoder_));
}

TEST_F(TexturedStreet, AnAtlasTooSmallIsRefusedAndCoarserTexelsTriedFirst) {
  Surface s = BuildSurface(*map_, {0, 0}, {kRule});
  const auto before = s.mesh.positions_m;
  EXPECT_FALSE(ApplyTexture(s, 0.1, Views(), {.max_atlas_px = 64}, encoder_));
  EXPECT_EQ(s.mesh.positions_m, before);
  const int least = 4 * (static_cast<int>(std::sqrt(s.quads.size())) + 1);
  EXPECT_TRUE(ApplyTexture(s, 0.1, Views(), {.max_atlas_px = least}, encoder_));
}

TEST_F(TexturedStreet, PicturesOfAnotherSizeAreRefused) {
  Surface s = BuildSurface(*map_, {0, 0}, {kRule});
  auto views = Views();
  views[1].picture.width_px = 10;
  EXPECT_FALSE(ApplyTexture(s, 0.1, views, {}, encoder_));
}

}  // namespace
}  // namespace kawara::vision
