#include <gtest/gtest.h>

#include <cmath>

#include "core/geodesy.hpp"
#include "vision/change/road_area.hpp"
#include "vision/change/road_axis.hpp"

namespace kawara::vision {
namespace {

RoadPolygon Rectangle(double x0, double y0, double x1, double y1) {
  return {"road", {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}, {}};
}

TEST(RoadArea, InsideOutsideAndHoles) {
  RoadPolygon polygon = Rectangle(-50, -4, 50, 4);
  polygon.holes.push_back({{-1, -1}, {1, -1}, {1, 1}, {-1, 1}});
  const RoadArea road = *RoadArea::Make({polygon});
  EXPECT_TRUE(road.Contains({10, 3.9}));
  EXPECT_FALSE(road.Contains({10, 4.1}));
  EXPECT_FALSE(road.Contains({0, 0}));
  EXPECT_NEAR(road.SignedDistance({20, 3.0}), 1.0, 1e-9);
  EXPECT_NEAR(road.SignedDistance({20, 4.5}), -0.5, 1e-9);
  EXPECT_NEAR(road.SignedDistance({0, 0.5}), -0.5, 1e-9);
  EXPECT_NEAR(road.SignedDistance({0, 300}), -RoadArea::kNear, 1e-9);
}

TEST(RoadArea, AnEdgeWithinAnotherPolygonIsNone) {
  const RoadArea road = *RoadArea::Make({Rectangle(-50, -4, 1, 4), Rectangle(-1, -4, 50, 4)});
  EXPECT_NEAR(road.SignedDistance({0, 0}), 4.0, 1e-9);
}

TEST(RoadArea, RefusesWhatIsNoArea) {
  EXPECT_FALSE(RoadArea::Make({}));
  EXPECT_FALSE(RoadArea::Make({{"line", {{0, 0}, {1, 1}}, {}}}));
  EXPECT_FALSE(RoadArea::Make({{"nan", {{0, 0}, {1, 1}, {std::nan(""), 0}}, {}}}));
}

TEST(RoadAxis, RunsAlongTheMiddleFromEndToEnd) {
  const auto axes = AxesOf(*RoadArea::Make({Rectangle(-50, -4, 50, 4)}));
  ASSERT_EQ(axes.size(), 1U);
  const auto& points = axes[0].points_m;
  EXPECT_NEAR(std::abs(points.front().x() - points.back().x()), 100.0, 1.5);
  for (const Eigen::Vector2d& p : points) EXPECT_NEAR(p.y(), 0.0, 0.3);
  EXPECT_NEAR(*RoadHeadingAt(axes, {3, 1}), core::kPi / 2, 0.03);
}

TEST(RoadAxis, FollowsABend) {
  RoadPolygon bend{"bend", {}, {}};
  std::vector<Eigen::Vector2d> inner;
  for (int i = 0; i <= 45; ++i) {
    const double a = i * core::kPi / 90.0;
    bend.outer.emplace_back(44 * std::cos(a), 44 * std::sin(a));
    inner.emplace_back(36 * std::cos(a), 36 * std::sin(a));
  }
  bend.outer.insert(bend.outer.end(), inner.rbegin(), inner.rend());
  const auto axes = AxesOf(*RoadArea::Make({bend}));
  ASSERT_EQ(axes.size(), 1U);
  // At its ends, where the skeleton bends into corners, it runs on straight.
  for (std::size_t i = 16; i + 16 < axes[0].points_m.size(); ++i)
    EXPECT_NEAR(axes[0].points_m[i].norm(), 40.0, 0.5);
  for (const Eigen::Vector2d& p : axes[0].points_m) EXPECT_NEAR(p.norm(), 40.0, 1.5);
}

TEST(RoadAxis, ALineOfTheGisIsKept) {
  const auto axis = AxisAlong("middle", {{0, 0}, {0, 0}, {10, 0}, {20, 0}});
  ASSERT_TRUE(axis);
  EXPECT_NEAR(axis->points_m.back().x(), 20.0, RoadAxis::kStep);
  EXPECT_FALSE(AxisAlong("point", {{1, 1}, {1, 1}}));
}

}  // namespace
}  // namespace kawara::vision
