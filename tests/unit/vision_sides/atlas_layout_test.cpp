#include "vision/sides/atlas_layout.hpp"

#include <gtest/gtest.h>

namespace kawara::vision {
namespace {

constexpr int kMargin = AtlasLayout::kMarginPx;

TEST(AtlasLayout, PicturesWithTheirMarginsDoNotTouch) {
  const std::vector<std::array<int, 2>> sizes{{380, 152}, {112, 152}, {112, 152},
                                              {380, 152}, {112, 380}, {4, 4}};
  const auto layout = LayOut(sizes, 1024);
  ASSERT_TRUE(layout);
  EXPECT_LE(layout->width_px, 1024);
  EXPECT_LE(layout->height_px, 1024);
  EXPECT_EQ(layout->width_px % 16, 0);
  EXPECT_EQ(layout->height_px % 16, 0);
  for (std::size_t a = 0; a < sizes.size(); ++a) {
    const auto& [x, y] = layout->place[a];
    EXPECT_GE(x, kMargin);
    EXPECT_GE(y, kMargin);
    EXPECT_LE(x + sizes[a][0] + kMargin, layout->width_px);
    EXPECT_LE(y + sizes[a][1] + kMargin, layout->height_px);
    for (std::size_t b = 0; b < a; ++b) {
      const auto& other = layout->place[b];
      EXPECT_TRUE(
          x >= other[0] + sizes[b][0] + 2 * kMargin || other[0] >= x + sizes[a][0] + 2 * kMargin ||
          y >= other[1] + sizes[b][1] + 2 * kMargin || other[1] >= y + sizes[a][1] + 2 * kMargin)
          << a << " and " << b;
    }
  }
}

TEST(AtlasLayout, WhatDoesNotFitIsSaid) {
  EXPECT_TRUE(LayOut(std::vector<std::array<int, 2>>{{60, 60}}, 64));
  EXPECT_FALSE(LayOut(std::vector<std::array<int, 2>>{{61, 4}}, 64));
  EXPECT_FALSE(LayOut(std::vector<std::array<int, 2>>{{4, 61}}, 64));
  EXPECT_FALSE(LayOut(std::vector<std::array<int, 2>>{{60, 40}, {60, 40}}, 64));
  // Not a whole block of a JPEG more than asked for.
  EXPECT_FALSE(LayOut(std::vector<std::array<int, 2>>{{62, 60}}, 70));
}

}  // namespace
}  // namespace kawara::vision
