#include "vision/sides/side_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace kawara::vision {
namespace {

using core::BoxSide;

core::ChangedObject Wagon() {
  core::ChangedObject object;
  object.box = {.centre_m = {3.0, -2.0, 0.75}, .size_m = {4.6, 1.7, 1.5}, .heading_rad = 0.0};
  return object;
}

TEST(SideGrid, NodesReachFromCornerToCorner) {
  for (std::size_t i = 0; i < core::kBoxSides; ++i) {
    const auto side = static_cast<BoxSide>(i);
    SCOPED_TRACE(core::ToString(side));
    const core::UprightBox box = Wagon().box;
    const SideGrid grid = GridOf(box, side, 0.02);
    const auto corners = box.CornersOf(side);
    EXPECT_LT((grid.corner_m - corners[0]).norm(), 1e-12);
    const Eigen::Vector3d last =
        grid.corner_m + grid.cell_columns * grid.right_m + grid.cell_rows * grid.down_m;
    EXPECT_LT((last - corners[2]).norm(), 1e-9);
    EXPECT_LE(grid.right_m.norm(), 0.02 * SideGrid::kStep + 1e-9);
    EXPECT_LE(grid.down_m.norm(), 0.02 * SideGrid::kStep + 1e-9);
    const Eigen::Vector3d middle = 0.5 * (corners[0] + corners[2]);
    EXPECT_GT(grid.normal.dot(middle - box.centre_m), 0.0);
    EXPECT_NEAR(grid.normal.norm(), 1.0, 1e-12);
  }
}

TEST(SideGrid, TheSmallestSideHasACell) {
  const SideGrid grid = GridOf({.size_m = {0.01, 0.01, 0.01}}, BoxSide::kLeft, 0.02);
  EXPECT_EQ(grid.cells(), 1U);
  EXPECT_EQ(grid.nodes(), 4U);
}

TEST(SideDeviation, IsThatOfThePlaceHalfTheSizeAndTheHeading) {
  core::ChangedObject wagon = Wagon();  // looks north
  EXPECT_EQ(SideDeviation(wagon, BoxSide::kLeft), 0.0);
  wagon.covariance(0, 0) = 0.09;  // east: to its right
  EXPECT_NEAR(SideDeviation(wagon, BoxSide::kLeft), 0.3, 1e-12);
  EXPECT_NEAR(SideDeviation(wagon, BoxSide::kFront), 0.0, 1e-9);
  wagon.covariance(4, 4) = 0.64;  // width
  EXPECT_NEAR(SideDeviation(wagon, BoxSide::kRight), 0.5, 1e-12);
  // Seen on its right: what makes it wider moves the middle to its left.
  wagon.covariance(4, 4) = 0.36;
  wagon.covariance(0, 4) = wagon.covariance(4, 0) = -0.18;
  EXPECT_NEAR(SideDeviation(wagon, BoxSide::kRight), 0.0, 1e-7);
  EXPECT_NEAR(SideDeviation(wagon, BoxSide::kLeft), 0.6, 1e-12);
  wagon.covariance.setZero();
  wagon.covariance(6, 6) = 0.01;
  EXPECT_NEAR(SideDeviation(wagon, BoxSide::kLeft), 0.1 * 4.6 / std::sqrt(12.0), 1e-12);
  EXPECT_EQ(SideDeviation(wagon, BoxSide::kTop), 0.0);
  wagon.covariance(2, 2) = 0.04;
  EXPECT_NEAR(SideDeviation(wagon, BoxSide::kTop), 0.2, 1e-12);
}

}  // namespace
}  // namespace kawara::vision
