#include "onboard/mapper/report/model_view.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "vision/jpeg.hpp"

namespace kawara::mapper {
namespace {

using core::ColouredPoint;
using Colour = std::array<std::uint8_t, 3>;

constexpr double kPointM = 0.1;
constexpr Colour kRed{220, 30, 30}, kBlue{30, 30, 220}, kGreen{30, 200, 30};
constexpr int kJpegLevels = 25;  // what JPEG may change

/// A level square of points, `half_m` to each side of (east, north).
void AddSquare(std::vector<ColouredPoint>& points, const Eigen::Vector3d& middle_m, double half_m,
               const Colour& colour) {
  const int steps = static_cast<int>(std::lround(half_m / kPointM));
  for (int i = -steps; i <= steps; ++i) {
    for (int k = -steps; k <= steps; ++k) {
      points.push_back({middle_m + Eigen::Vector3d(i * kPointM, k * kPointM, 0.0), colour, 1});
    }
  }
}

class Pixels {
 public:
  explicit Pixels(const ReportPicture& picture) { view_ = *decoder_.Decode(picture.bytes); }
  /// At parts (0..1) of the width and height.
  void Expect(double x, double y, const Colour& colour) const {
    const auto* at = view_.row(static_cast<int>(y * (view_.height_px - 1))) +
                     3 * static_cast<int>(x * (view_.width_px - 1));
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(at[k], colour[k], kJpegLevels) << "at " << x << " " << y << " channel " << k;
    }
  }

 private:
  vision::JpegDecoder decoder_;
  vision::ConstImageView view_;
};

ReportPicture View(ViewFrom from, const std::vector<ColouredPoint>& points) {
  ModelView view(from, BoxOf(points), kPointM, 320);
  view.Add(points);
  return view.Picture();
}

PointParts Whole(const std::vector<ColouredPoint>& points) {
  return [points](const TakePoints& take) -> core::Expected<void> {
    take(points);
    return {};
  };
}

TEST(ModelView, FromAboveNorthIsUpAndEastRight) {
  std::vector<ColouredPoint> points;
  AddSquare(points, {100.0, 200.0, 0.0}, 1.0, kGreen);  // south-west
  AddSquare(points, {104.0, 200.0, 0.0}, 1.0, kRed);    // south-east
  AddSquare(points, {100.0, 204.0, 0.0}, 1.0, kBlue);   // north-west
  const Pixels pixels(View(ViewFrom::kAbove, points));
  pixels.Expect(0.15, 0.85, kGreen);
  pixels.Expect(0.85, 0.85, kRed);
  pixels.Expect(0.15, 0.15, kBlue);
  pixels.Expect(0.85, 0.15, {245, 245, 245});
}

TEST(ModelView, WhatIsNearerCoversWhateverTheOrder) {
  for (const bool upper_first : {true, false}) {
    std::vector<ColouredPoint> points;
    AddSquare(points, {0.0, 0.0, upper_first ? 2.0 : 0.0}, 1.0, upper_first ? kRed : kBlue);
    AddSquare(points, {0.0, 0.0, upper_first ? 0.0 : 2.0}, 1.0, upper_first ? kBlue : kRed);
    Pixels(View(ViewFrom::kAbove, points)).Expect(0.5, 0.5, kRed);
  }
}

TEST(ModelView, ObliqueViewsShowTheSideTheyAreNamedFor) {
  // A wall from south-west to north-east, red to the south-east, blue to the north-west.
  std::vector<ColouredPoint> points;
  for (int along = -20; along <= 20; ++along) {
    for (int up = 0; up <= 30; ++up) {
      const Eigen::Vector3d m(along * 0.07, along * 0.07, up * kPointM);
      points.push_back({m + Eigen::Vector3d(0.2, -0.2, 0.0), kRed, 1});
      points.push_back({m + Eigen::Vector3d(-0.2, 0.2, 0.0), kBlue, 1});
    }
  }
  Pixels(View(ViewFrom::kSouthEast, points)).Expect(0.5, 0.6, kRed);
  Pixels(View(ViewFrom::kNorthWest, points)).Expect(0.5, 0.6, kBlue);
}

TEST(ModelView, ObliqueViewsHaveHeightUpwards) {
  std::vector<ColouredPoint> points;
  for (int up = 0; up <= 40; ++up) {
    for (int k = 0; k <= 5; ++k) {
      points.push_back({{k * kPointM, k * kPointM, up * kPointM}, up > 20 ? kRed : kBlue, 1});
    }
  }
  for (const ViewFrom from : {ViewFrom::kSouthEast, ViewFrom::kNorthWest}) {
    const Pixels pixels(View(from, points));
    pixels.Expect(0.5, 0.2, kRed);
    pixels.Expect(0.5, 0.8, kBlue);
  }
}

TEST(ModelView, PartsMakeTheSamePictureAsTheWhole) {
  std::vector<ColouredPoint> points;
  AddSquare(points, {0.0, 0.0, 0.0}, 1.0, kRed);
  AddSquare(points, {1.5, 0.5, 1.0}, 0.5, kBlue);
  ModelView parts(ViewFrom::kSouthEast, BoxOf(points), kPointM, 320);
  const std::span<const ColouredPoint> all(points);
  parts.Add(all.subspan(100));
  parts.Add(all.first(100));
  EXPECT_EQ(parts.Picture().bytes, View(ViewFrom::kSouthEast, points).bytes);
}

TEST(ModelView, ScaleIsThatOfThePicture) {
  std::vector<ColouredPoint> points;
  AddSquare(points, {0.0, 0.0, 0.0}, 2.0, kRed);
  const ReportPicture picture = View(ViewFrom::kAbove, points);
  // From the first point's middle to the last one's, and a point's diagonal.
  EXPECT_NEAR(picture.width_px, (4.0 + std::numbers::sqrt2 * kPointM) * picture.px_per_m, 2.0);
}

TEST(ModelView, NumbersThatAreNoneDrawNothing) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<ColouredPoint> points{{{kNan, 0.0, 0.0}, kRed, 1}, {{1e300, 0, 0}, kRed, 1}};
  ModelView view(ViewFrom::kAbove, {{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}}, kPointM, 64);
  view.Add(points);
  EXPECT_TRUE(view.Picture().bytes.empty());
  EXPECT_TRUE(DrawModelViews(Whole({}), kPointM)->empty());
}

TEST(ModelView, OnePointIsAPicture) {
  const std::vector<ColouredPoint> points{{{5.0, 6.0, 7.0}, kRed, 1}};
  const auto views = DrawModelViews(Whole(points), kPointM);
  ASSERT_TRUE(views);
  ASSERT_EQ(views->size(), 3U);
  for (const auto& view : *views) Pixels(view).Expect(0.5, 0.5, kRed);
}

TEST(ModelView, APartThatCannotBeReadIsAnError) {
  const auto views = DrawModelViews(
      [](const TakePoints&) { return core::Fail(core::ErrorCode::kIo, "gone"); }, kPointM);
  ASSERT_FALSE(views);
  EXPECT_EQ(views.error().message, "gone");
}

TEST(BoxOf, AFewStraysDoNotCount) {
  std::vector<ColouredPoint> points;
  AddSquare(points, {0.0, 0.0, 0.0}, 5.0, kRed);  // over 10000
  points.push_back({{1000.0, 1000.0, 1000.0}, kRed, 1});
  const MapBox box = BoxOf(points);
  EXPECT_NEAR(box.max_m.x(), 5.0, kPointM);
  EXPECT_NEAR(box.min_m.y(), -5.0, kPointM);
}

}  // namespace
}  // namespace kawara::mapper
