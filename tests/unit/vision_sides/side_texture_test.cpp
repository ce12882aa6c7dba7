#include "vision/sides/side_texture.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "painted_car.hpp"
#include "vision/camera/equirectangular_camera.hpp"

namespace kawara::vision {
namespace {

TEST_F(PaintedCar, EverySideIsItsPaintTheRightWayRound) {
  Pass();
  const auto textures = Make(Views());
  EXPECT_EQ(SidesOf(textures), (Sides{BoxSide::kFront, BoxSide::kRear, BoxSide::kRight}));
  const auto as_it_is = [](double s, double t) { return Eigen::Vector2d(s, t); };
  const std::vector<Turn> wrong{[](double s, double t) { return Eigen::Vector2d(1 - s, t); },
                                [](double s, double t) { return Eigen::Vector2d(s, 1 - t); },
                                [](double s, double t) { return Eigen::Vector2d(1 - s, 1 - t); },
                                [](double s, double t) { return Eigen::Vector2d(t, s); },
                                [](double s, double t) { return Eigen::Vector2d(1 - t, s); }};
  for (const auto& face : textures.faces) {
    SCOPED_TRACE(core::ToString(face.side));
    EXPECT_GT(face.seen_share, 0.95);
    EXPECT_LT(ErrorOf(textures, face.side), 8.0);
    for (std::size_t c = 0; c < 2; ++c) {
      EXPECT_GT(Correlation(textures, face.side, c, as_it_is), 0.95) << c;
    }
    for (const Turn& turn : wrong) {
      const double least = std::min(Correlation(textures, face.side, 0, turn),
                                    Correlation(textures, face.side, 1, turn));
      EXPECT_LT(least, 0.5);
    }
  }
}

TEST_F(PaintedCar, TheTopIsShownFrontUpwardsIfACameraStandsAboveIt) {
  for (const double x : {-4.0, -2.0, 0.0, 2.0, 4.0}) Look(x, -2.0, kHigh);
  const auto textures = Make(Views());
  const auto* top = FaceOf(textures, BoxSide::kTop);
  ASSERT_NE(top, nullptr);
  EXPECT_GT(top->seen_share, 0.95);
  EXPECT_GT(top->corners_px[3][1] - top->corners_px[0][1],
            2.0 * (top->corners_px[1][0] - top->corners_px[0][0]));
  const auto as_it_is = [](double s, double t) { return Eigen::Vector2d(s, t); };
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_GT(Correlation(textures, BoxSide::kTop, c, as_it_is), 0.95) << c;
}

TEST_F(PaintedCar, SidesNobodySawGetNoPicture) {
  Pass();
  object_.side_seen = {true, true, false, false, false};  // the left one by somebody else
  EXPECT_EQ(SidesOf(Make(Views())), Sides{BoxSide::kFront});
  object_.side_seen = {};
  const auto none = Make(Views());
  EXPECT_TRUE(none.faces.empty());
  EXPECT_TRUE(none.atlas_jpeg.empty());
}

TEST_F(PaintedCar, NoViewsAreNoTexturesAndNoError) {
  const auto none = Make({});
  EXPECT_TRUE(none.faces.empty());
  EXPECT_TRUE(none.atlas_jpeg.empty());
  EXPECT_EQ(none.width_px, 0U);
}

TEST_F(PaintedCar, TheViewThatLooksStraightestAtASideIsItsSource) {
  Pass();
  const auto textures = Make(Views());
  const auto* right = FaceOf(textures, BoxSide::kRight);
  ASSERT_NE(right, nullptr);
  EXPECT_EQ(right->source, "m1/3");  // abeam
  EXPECT_EQ(right->taken.ns(), 1003);
}

TEST_F(PaintedCar, WhatAPillarHidesComesFromAnotherView) {
  const Eigen::Vector3d foot = Pose(0.0, -2.0, 0.0).translation();
  world_.pillars.emplace_back(foot - Eigen::Vector3d(0.15, 0.15, 0),
                              foot + Eigen::Vector3d(0.15, 0.15, 2.5));
  Look(0.0, -3.2);
  Look(2.0, -3.2);
  object_.side_seen = {false, false, false, true, false};
  auto views = Views();
  const auto both = Make(views);
  EXPECT_EQ(RedOn(both, BoxSide::kRight), 0);
  EXPECT_GT(FaceOf(both, BoxSide::kRight)->seen_share, 0.97);
  EXPECT_LT(ErrorOf(both, BoxSide::kRight), 8.0);
  // The first one alone: a hole in the side's mean colour, and it is told.
  const auto alone = Make({views[0]});
  EXPECT_EQ(RedOn(alone, BoxSide::kRight), 0);
  EXPECT_LT(FaceOf(alone, BoxSide::kRight)->seen_share, 0.9);
  EXPECT_GT(FaceOf(alone, BoxSide::kRight)->seen_share, 0.6);
  // The test's pillar is in the picture: without ranges it is painted on the side.
  views[0].view.ranges = nullptr;
  EXPECT_GT(RedOn(Make({views[0]}), BoxSide::kRight), 100);
}

TEST_F(PaintedCar, RangesOfHalfTheSizeHideAsMuch) {
  const Eigen::Vector3d foot = Pose(0.0, -2.0, 0.0).translation();
  world_.pillars.emplace_back(foot - Eigen::Vector3d(0.15, 0.15, 0),
                              foot + Eigen::Vector3d(0.15, 0.15, 2.5));
  Look(0.0, -3.2);
  object_.side_seen = {false, false, false, true, false};
  auto views = Views();
  const double by_whole = FaceOf(Make(views), BoxSide::kRight)->seen_share;
  const RangeImage half = RangesForTexture(looks_[0].ranges);
  views[0].view.ranges = &half;
  const auto textures = Make(views);
  EXPECT_EQ(RedOn(textures, BoxSide::kRight), 0);
  EXPECT_NEAR(FaceOf(textures, BoxSide::kRight)->seen_share, by_whole, 0.03);
}

TEST_F(PaintedCar, ASideAcrossAPanoramasSeamIsWholeButForTheSeam) {
  // The panorama's first and last columns look backwards, at the middle of the side.
  const auto panorama = *EquirectangularCamera::Create(PanoramaGeometry::Full(1024, 512));
  Eigen::Isometry3d pose = Pose(0.0, -3.2);
  pose = testing::UprightCamera(pose.translation(), object_.box.heading_rad + core::kPi / 2);
  const auto look = world_.LookAt(panorama, pose);
  object_.side_seen = {false, false, false, true, false};
  const auto textures = Make({{.view = {.camera = panorama,
                                        .picture = look.picture(),
                                        .ranges = &look.ranges,
                                        .map_from_camera = pose}}});
  const double seen = FaceOf(textures, BoxSide::kRight)->seen_share;
  EXPECT_GT(seen, 0.9);
  EXPECT_LT(seen, 1.0);
  EXPECT_LT(ErrorOf(textures, BoxSide::kRight), 8.0);
}

TEST_F(PaintedCar, SingleWrongRangesHideNothing) {
  Look(0.0, -3.2);
  for (std::size_t i = 0; i < looks_[0].ranges.range_m.size(); i += 7)
    looks_[0].ranges.range_m[i] = 0.5F;
  object_.side_seen = {false, false, false, true, false};
  const auto textures = Make(Views());
  EXPECT_GT(FaceOf(textures, BoxSide::kRight)->seen_share, 0.99);
}

TEST_F(PaintedCar, MaskedPixelsAreNotTaken) {
  Look(0.0, -3.2);
  Look(2.0, -3.2);
  object_.side_seen = {false, false, false, true, false};
  // The robot's mast, painted red, before the middle of the side.
  std::vector<std::uint8_t> mask(looks_[0].pixels.size() / 3, 255);
  const Eigen::Vector3d foot = Pose(0.0, -2.0, 0.0).translation();
  testing::PaintedBox with_mast = world_;
  with_mast.pillars.emplace_back(foot - Eigen::Vector3d(0.15, 0.15, 0),
                                 foot + Eigen::Vector3d(0.15, 0.15, 2.5));
  const auto mast = with_mast.LookAt(camera_, Pose(0.0, -3.2));
  for (std::size_t i = 0; i < mask.size(); ++i)
    if (mast.pixels[3 * i] != looks_[0].pixels[3 * i]) mask[i] = 0;
  looks_[0].pixels = mast.pixels;  // its ranges know nothing of it
  auto views = Views();
  EXPECT_GT(RedOn(Make(views), BoxSide::kRight), 50);
  views[0].mask = mask;
  const auto textures = Make(views);
  EXPECT_EQ(RedOn(textures, BoxSide::kRight), 0);
  EXPECT_GT(FaceOf(textures, BoxSide::kRight)->seen_share, 0.97);
}

TEST_F(PaintedCar, ABlurredPictureLosesToASharpOne) {
  Look(0.0, -3.2);
  Look(0.05, -3.2);
  object_.side_seen = {false, false, false, true, false};
  // Turned while exposed: the mean along 11 pixels.
  const auto blur = [](testing::PaintedView view) {
    const auto sharp = view.pixels;
    const int width = view.ranges.width_px;
    for (int v = 0; v < view.ranges.height_px; ++v)
      for (int u = 5; u + 5 < width; ++u)
        for (std::size_t c = 0; c < 3; ++c) {
          int sum = 0;
          for (int k = -5; k <= 5; ++k) sum += sharp[3 * view.ranges.index(u + k, v) + c];
          view.pixels[3 * view.ranges.index(u, v) + c] = static_cast<std::uint8_t>(sum / 11);
        }
    return view;
  };
  const auto sharp = looks_;
  for (const std::size_t which : {std::size_t{0}, std::size_t{1}}) {
    looks_ = sharp;
    looks_[which] = blur(sharp[which]);
    const auto textures = Make(Views());
    EXPECT_EQ(FaceOf(textures, BoxSide::kRight)->source, which == 0 ? "m1/1" : "m1/0");
  }
  // Brighter is not sharper.
  looks_ = sharp;
  looks_[0] = blur(sharp[0]);
  for (auto& p : looks_[1].pixels) p = static_cast<std::uint8_t>(0.5 * p);
  EXPECT_EQ(FaceOf(Make(Views()), BoxSide::kRight)->source, "m1/1");
}

TEST_F(PaintedCar, AnotherExposureLeavesNoSeam) {
  // Abeam, but nothing of the side's left 40 % in it; the other one further off and darker.
  Look(0.0, -3.2);
  Look(-2.5, -7.0);
  for (auto& p : looks_[1].pixels) p = static_cast<std::uint8_t>(std::lround(0.7 * p));
  object_.side_seen = {false, false, false, true, false};
  const double seam_m = 0.4 * object_.box.size_m.x();
  std::vector<std::uint8_t> mask(looks_[0].pixels.size() / 3, 255);
  const Eigen::Isometry3d pose = looks_[0].map_from_camera;
  for (int v = 0; v < camera_.height_px(); ++v)
    for (int u = 0; u < camera_.width_px(); ++u) {
      const auto ray = camera_.Unproject({u, v});
      const float range = looks_[0].ranges.range_m[looks_[0].ranges.index(u, v)];
      if (!ray || std::isnan(range)) continue;
      const Eigen::Vector2d at =
          (pose * (static_cast<double>(range) * *ray) - object_.box.centre_m).head<2>();
      if (at.dot(object_.box.Forward()) + object_.box.size_m.x() / 2 < seam_m)
        mask[looks_[0].ranges.index(u, v)] = 0;
    }
  auto views = Views();
  views[0].mask = mask;
  const auto textures = Make(views);
  EXPECT_EQ(FaceOf(textures, BoxSide::kRight)->source, "m1/0");
  EXPECT_GT(FaceOf(textures, BoxSide::kRight)->seen_share, 0.97);
  // Brightness beside the paint's, in the strips on both sides of the seam, and on the whole.
  std::array<double, 2> here{}, paint{}, all_here{}, all_paint{};
  ForPlaces(textures, BoxSide::kRight,
            [&](double right, double down, const std::array<double, 3>& rgb) {
              const auto truth = world_.Paint(BoxSide::kRight, right, down);
              const std::size_t k = right < seam_m ? 0 : 1;
              for (std::size_t c = 0; c < 3; ++c) {
                all_here[k] += rgb[c];
                all_paint[k] += truth[c];
                if (std::abs(right - seam_m) > 0.5) continue;
                here[k] += rgb[c];
                paint[k] += truth[c];
              }
            });
  EXPECT_NEAR(here[0] / paint[0], here[1] / paint[1], 0.03);
  EXPECT_NEAR(all_here[0] / all_paint[0], 1.0, 0.03);
  EXPECT_NEAR(all_here[1] / all_paint[1], 1.0, 0.03);
}

TEST_F(PaintedCar, TheSameInputGivesTheSameBytes) {
  Pass();
  const auto views = Views();
  const auto once = Make(views);
  JpegEncoder other;
  const auto again = MakeSideTextures(object_, views, {}, other);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->atlas_jpeg, once.atlas_jpeg);
  EXPECT_LT(once.atlas_jpeg.size(), 60'000U);
}

TEST_F(PaintedCar, ALargeThingGetsCoarserTexelsInASmallAtlas) {
  Pass();
  object_.box.size_m = {28.0, 19.0, 1.6};
  object_.side_seen = {true, true, true, true, false};
  Look(0.0, -20.0);
  Look(20.0, 0.0);
  const auto textures = Make(Views(), {.max_atlas_px = 200, .min_seen_share = 0.01});
  ASSERT_FALSE(textures.faces.empty());
  EXPECT_LE(textures.width_px, 200U);
  EXPECT_LE(textures.height_px, 200U);
  for (const auto& face : textures.faces)
    for (const auto& [x, y] : face.corners_px) {
      EXPECT_TRUE(x >= 0.0 && x <= textures.width_px);
      EXPECT_TRUE(y >= 0.0 && y <= textures.height_px);
    }
}

TEST_F(PaintedCar, WhatDoesNotFitTogetherIsRefused) {
  Look(0.0, -3.2);
  const auto refused = [&](const core::ChangedObject& object, const SideView& view,
                           const SideTextureConfig& config) {
    const auto made = MakeSideTextures(object, std::array{view}, config, encoder_);
    return !made && made.error().code == core::ErrorCode::kInvalidArgument;
  };
  const SideView good = Views()[0];
  EXPECT_FALSE(refused(object_, good, {}));
  SideView view = good;
  view.view.picture.width_px -= 2;
  EXPECT_TRUE(refused(object_, view, {}));
  RangeImage third;
  third.Reset(camera_.width_px() / 3, camera_.height_px() / 3);
  SideView with_third = good;
  with_third.view.ranges = &third;
  EXPECT_TRUE(refused(object_, with_third, {}));
  RangeImage torn = looks_[0].ranges;
  torn.range_m.pop_back();
  SideView with_torn = good;
  with_torn.view.ranges = &torn;
  EXPECT_TRUE(refused(object_, with_torn, {}));
  const std::vector<std::uint8_t> mask(17, 255);
  SideView masked = good;
  masked.mask = mask;
  EXPECT_TRUE(refused(object_, masked, {}));
  SideView lost = good;
  lost.view.map_from_camera.translation().x() = std::nan("");
  EXPECT_TRUE(refused(object_, lost, {}));
  core::ChangedObject flat = object_;
  flat.box.size_m.y() = 0.0;
  EXPECT_TRUE(refused(flat, good, {}));
  EXPECT_TRUE(refused(object_, good, {.texel_m = 0.0}));
  EXPECT_TRUE(refused(object_, good, {.max_atlas_px = 63}));
  EXPECT_TRUE(refused(object_, good, {.jpeg_quality = 101}));
}

}  // namespace
}  // namespace kawara::vision
