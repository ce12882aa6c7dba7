#include "vision/stereo/coarse_matcher.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace kawara::vision {
namespace {

constexpr int kWidth = 96, kHeight = 40, kDisparities = 32;

std::size_t At(int x, int y) {
  return static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x);
}

ContrastPlane Plane(std::uint8_t level = ContrastPlane::kMiddle) {
  ContrastPlane plane;
  plane.width_px = kWidth;
  plane.height_px = kHeight;
  plane.level.assign(std::size_t{kWidth} * kHeight, level);
  plane.seen.assign(plane.level.size(), 255);
  plane.plain.assign(plane.level.size(), 0);
  return plane;
}

ContrastPlane Noise(std::uint32_t seed) {
  ContrastPlane plane = Plane();
  std::mt19937 dice(seed);
  for (auto& level : plane.level) level = static_cast<std::uint8_t>(dice() % 256);
  return plane;
}

/// What B sees when A's row y is shifted by shift(y); the rest of B is another picture.
template <class Shift>
ContrastPlane Shifted(const ContrastPlane& a, const Shift& shift) {
  ContrastPlane b = Noise(77);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x + shift(y) < kWidth; ++x) b.level[At(x + shift(y), y)] = a.level[At(x, y)];
  }
  return b;
}

TEST(CoarseMatcher, FindsAStepOfDisparity) {
  const ContrastPlane a = Noise(1);
  const auto shift = [](int y) { return y < kHeight / 2 ? 7 : 19; };
  CoarseMatcher matcher;
  std::vector<float> found;
  matcher.Match(a, Shifted(a, shift), kDisparities, found);
  int right = 0, wrong = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x + 19 < kWidth; ++x) {
      const float disparity = found[At(x, y)];
      if (disparity < 0.0F) continue;
      (std::abs(disparity - static_cast<float>(shift(y))) < 1.0F ? right : wrong) += 1;
    }
  }
  EXPECT_GT(right, (kWidth - 19) * kHeight * 9 / 10);
  EXPECT_LT(wrong, right / 50);
}

RectifiedPicture NoisyPicture(std::uint32_t seed, double level_per_column) {
  RectifiedPicture picture;
  EpipolarGrid grid;
  grid.width_px = 2 * kWidth;
  grid.height_px = 2 * kHeight;
  picture.Resize(grid);
  std::mt19937 dice(seed);
  for (int y = 0; y < grid.height_px; ++y) {
    for (int x = 0; x < grid.width_px; ++x) {
      const auto grey = static_cast<std::uint32_t>(100.0 + level_per_column * x);
      std::uint32_t word = 0xFF000000U;
      for (int c = 0; c < 24; c += 8) word |= (grey + static_cast<std::uint32_t>(dice() % 7)) << c;
      picture.row(y)[x] = word;
    }
  }
  return picture;
}

TEST(CoarseMatcher, PlainSurfacesStayUnknown) {
  ContrastMaker maker;
  ContrastPlane a, b;
  maker.Make(NoisyPicture(1, 0.0), a);
  maker.Make(NoisyPicture(2, 0.0), b);
  CoarseMatcher matcher;
  std::vector<float> found;
  matcher.Match(a, b, kDisparities, found);
  EXPECT_LT(std::count_if(found.begin(), found.end(), [](float d) { return d >= 0.0F; }),
            kWidth * kHeight / 50);
}

TEST(CoarseMatcher, WhatRepeatsItselfStaysUnknown) {
  ContrastPlane fence = Plane();
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) fence.level[At(x, y)] = x % 8 < 4 ? 60 : 200;
  }
  CoarseMatcher matcher;
  std::vector<float> found;
  matcher.Match(fence, fence, kDisparities, found);
  // Where B ends sooner than the fence repeats there is but one candidate.
  int known = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x + kDisparities < kWidth; ++x) known += found[At(x, y)] >= 0.0F ? 1 : 0;
  }
  EXPECT_LT(known, kWidth * kHeight / 50);
}

TEST(CoarseMatcher, NothingIsSaidOfWhatIsNotSeen) {
  ContrastPlane a = Noise(1);
  for (int x = 30; x < 50; ++x) a.seen[At(x, 20)] = 0;
  CoarseMatcher matcher;
  std::vector<float> found;
  matcher.Match(a, Shifted(a, [](int) { return 5; }), kDisparities, found);
  for (int x = 30; x < 50; ++x) EXPECT_LT(found[At(x, 20)], 0.0F);
  EXPECT_GE(found[At(40, 10)], 0.0F);
}

TEST(CoarseMatcher, ASecondPairIsNotAffectedByTheFirst) {
  const ContrastPlane a = Noise(1);
  const ContrastPlane b = Shifted(a, [](int) { return 11; });
  CoarseMatcher fresh, used;
  std::vector<float> expected, found;
  fresh.Match(a, b, kDisparities, expected);
  used.Match(Noise(5), Noise(6), 48, found);
  used.Match(a, b, kDisparities, found);
  EXPECT_EQ(found, expected);
}

TEST(SpeckleFilter, TakesSmallRegionsAndLeavesLargeOnes) {
  std::vector<float> disparity(100, CoarseMatcher::kUnknown);
  const auto set = [&](int x, int y, float d) {
    disparity[static_cast<std::size_t>(10 * y + x)] = d;
  };
  for (int x = 0; x < 6; ++x)
    set(x, 1, 5.0F + 0.5F * static_cast<float>(x));  // connected by small steps
  for (int x = 0; x < 3; ++x) set(x, 5, 9.0F);
  set(3, 5, 12.0F);  // beside, but of another surface
  SpeckleFilter().Clean(10, 10, 4, 1.0F, disparity);
  EXPECT_FLOAT_EQ(disparity[10], 5.0F);
  EXPECT_FLOAT_EQ(disparity[15], 7.5F);
  for (std::size_t x = 0; x < 4; ++x) EXPECT_LT(disparity[50 + x], 0.0F);
}

}  // namespace
}  // namespace kawara::vision
