#include "sim/site/polygon.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace kawara::sim {
namespace {

using Polygon = std::vector<Eigen::Vector2d>;

const Polygon kSquare{{0, 0}, {2, 0}, {2, 2}, {0, 2}};
const Polygon kL{{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}};
const Polygon kBow{{0, 0}, {2, 2}, {2, 0}, {0, 2}};

double AreaOfTriangles(const Polygon& p) {
  double area = 0;
  for (const auto& t : Triangulate(p)) area += SignedArea({p[t[0]], p[t[1]], p[t[2]]});
  return area;
}

TEST(Polygon, TrianglesFillIt) {
  Polygon star;
  for (int i = 0; i < 14; ++i) {
    const double r = i % 2 == 0 ? 2.0 : 0.6, turn = 3.14159265 * i / 7;
    star.emplace_back(r * std::cos(turn), r * std::sin(turn));
  }
  for (const Polygon& p : {kSquare, kL, star}) {
    EXPECT_NEAR(AreaOfTriangles(p), SignedArea(p), 1e-9);
    EXPECT_EQ(Triangulate(p).size(), p.size() - 2);
  }
}

TEST(Polygon, SimpleMeansCounterClockwiseAndWithoutCrossings) {
  EXPECT_TRUE(IsSimplePolygon(kSquare));
  EXPECT_TRUE(IsSimplePolygon(kL));
  EXPECT_FALSE(IsSimplePolygon(kBow));
  EXPECT_FALSE(IsSimplePolygon(Polygon(kSquare.rbegin(), kSquare.rend())));
  EXPECT_FALSE(IsSimplePolygon(Polygon{{0, 0}, {1, 0}}));
  EXPECT_FALSE(IsSimplePolygon(Polygon{{0, 0}, {4, 0}, {4, 4}, {2, 0}, {0, 4}}));  // touches
}

TEST(Polygon, DistanceIsZeroInsideAndToTheNearestSideOutside) {
  EXPECT_EQ(DistanceTo(kL, {0.5, 2.5}), 0.0);
  EXPECT_NEAR(DistanceTo(kL, {2.0, 2.0}), 1.0, 1e-12);
  EXPECT_NEAR(DistanceTo(kL, {-3.0, -4.0}), 5.0, 1e-12);
}

TEST(Polygon, CuttingSplitsTheAreaInTwo) {
  const Eigen::Vector2d a(-1, 0.3), b(4, 1.9);
  EXPECT_NEAR(SignedArea(CutLeft(kSquare, a, b)) + SignedArea(CutLeft(kSquare, b, a)), 4.0, 1e-12);
  EXPECT_TRUE(CutLeft(kSquare, {0, -1}, {-1, -1}).empty());
}

}  // namespace
}  // namespace kawara::sim
