#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/box_world.hpp"
#include "tests/support/painted_box.hpp"
#include "tests/support/test_doughnut.hpp"
#include "vision/sides/side_texture.hpp"

namespace kawara::vision {

using core::BoxSide;
using Sides = std::vector<BoxSide>;

constexpr double kLow = 1.2, kHigh = 2.6;  // of the camera, m above the road; the box has 1.6

/// A car on a road whose paint is known, and what its textures make of that.
class PaintedCar : public ::testing::Test {
 protected:
  PaintedCar() {
    object_.uid = "car-1";
    object_.box = {.centre_m = {12.0, -7.0, 0.8}, .size_m = {4.6, 1.7, 1.6}, .heading_rad = 0.6};
    object_.side_seen = {true, false, true, true, false};
    world_.box = object_.box;
  }

  /// A camera at a place of the box's own frame: along its heading, to its left, above the road.
  Eigen::Isometry3d Pose(double ahead_m, double left_m, double up_m = kLow) const {
    Eigen::Vector3d at(0, 0, up_m);
    at.head<2>() = object_.box.centre_m.head<2>() + ahead_m * object_.box.Forward() +
                   left_m * object_.box.Left();
    return testing::UprightCamera(at, object_.box.heading_rad + 0.3);
  }
  void Look(double ahead_m, double left_m, double up_m = kLow) {
    looks_.push_back(world_.LookAt(camera_, Pose(ahead_m, left_m, up_m)));
  }
  /// The robot's way past it, on its right.
  void Pass() {
    for (const double x : {-6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0}) Look(x, -3.2);
  }
  std::vector<SideView> Views() const {
    std::vector<SideView> views;
    for (std::size_t i = 0; i < looks_.size(); ++i)
      views.push_back({.view = {.camera = camera_,
                                .picture = looks_[i].picture(),
                                .ranges = &looks_[i].ranges,
                                .map_from_camera = looks_[i].map_from_camera},
                       .source = "m1/" + std::to_string(i),
                       .taken = core::UtcTime::FromNs(1000 + static_cast<std::int64_t>(i))});
    return views;
  }
  core::ObjectTextures Make(const std::vector<SideView>& views, const SideTextureConfig& c = {}) {
    auto made = MakeSideTextures(object_, views, c, encoder_);
    EXPECT_TRUE(made) << made.error().message;
    return made ? *made : core::ObjectTextures{};
  }
  static const core::FaceTexture* FaceOf(const core::ObjectTextures& t, BoxSide side) {
    const auto found = std::find_if(t.faces.begin(), t.faces.end(),
                                    [side](const auto& f) { return f.side == side; });
    return found == t.faces.end() ? nullptr : &*found;
  }
  static Sides SidesOf(const core::ObjectTextures& t) {
    Sides sides;
    for (const auto& f : t.faces) sides.push_back(f.side);
    return sides;
  }

  /// visit(right_m, down_m, rgb) for places of a side 4 cm apart, where its corners say they are.
  template <class Visit>
  void ForPlaces(const core::ObjectTextures& t, BoxSide side, const Visit& visit) {
    const auto* face = FaceOf(t, side);
    ASSERT_NE(face, nullptr) << core::ToString(side);
    JpegDecoder decoder;
    const auto atlas = decoder.Decode(t.atlas_jpeg);
    ASSERT_TRUE(atlas);
    ASSERT_EQ(atlas->width_px, static_cast<int>(t.width_px));
    ASSERT_EQ(atlas->height_px, static_cast<int>(t.height_px));
    const Eigen::Vector2d size = world_.SizeOf(side);
    const auto& c = face->corners_px;
    for (double right = 0.02; right < size.x(); right += 0.04)
      for (double down = 0.02; down < size.y(); down += 0.04) {
        const double s = right / size.x(), d = down / size.y();
        const double x = c[0][0] + s * (c[1][0] - c[0][0]) + d * (c[3][0] - c[0][0]);
        const double y = c[0][1] + s * (c[1][1] - c[0][1]) + d * (c[3][1] - c[0][1]);
        const std::uint8_t* const rgb =
            atlas->row(static_cast<int>(y)) + std::ptrdiff_t{kRgbBytes} * static_cast<int>(x);
        visit(right, down, std::array<double, 3>{double(rgb[0]), double(rgb[1]), double(rgb[2])});
      }
  }

  /// Correlation of a channel with the paint at turn(right, down), places in shares of the side.
  using Turn = std::function<Eigen::Vector2d(double, double)>;
  double Correlation(const core::ObjectTextures& t, BoxSide side, std::size_t channel,
                     const Turn& turn) {
    double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    const Eigen::Vector2d size = world_.SizeOf(side);
    ForPlaces(t, side, [&](double right, double down, const std::array<double, 3>& rgb) {
      const Eigen::Vector2d at = turn(right / size.x(), down / size.y()).cwiseProduct(size);
      const double x = rgb[channel], y = world_.Paint(side, at.x(), at.y())[channel];
      n += 1, a += x, b += y, aa += x * x, bb += y * y, ab += x * y;
    });
    return (ab - a * b / n) / std::sqrt((aa - a * a / n) * (bb - b * b / n));
  }
  /// Mean difference of the colours from the paint [levels].
  double ErrorOf(const core::ObjectTextures& t, BoxSide side) {
    double sum = 0.0, n = 0.0;
    ForPlaces(t, side, [&](double right, double down, const std::array<double, 3>& rgb) {
      const auto truth = world_.Paint(side, right, down);
      for (std::size_t c = 0; c < 3; ++c) sum += std::abs(rgb[c] - truth[c]);
      n += 3.0;
    });
    return sum / n;
  }
  /// Places of a side that are the pillar's red.
  int RedOn(const core::ObjectTextures& t, BoxSide side) {
    int red = 0;
    ForPlaces(t, side, [&](double, double, const std::array<double, 3>& rgb) {
      red += rgb[0] > 200.0 && rgb[1] < 60.0 && rgb[2] < 60.0 ? 1 : 0;
    });
    return red;
  }

  core::ChangedObject object_;
  testing::PaintedBox world_;
  DoughnutCamera camera_ = *DoughnutCamera::Create(TestDoughnut(512));
  std::vector<testing::PaintedView> looks_;
  JpegEncoder encoder_;
};

}  // namespace kawara::vision
