#include "vision/refine/patch_align.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace kawara::vision {
namespace {

/// A smooth pattern without a period that can be looked at anywhere.
class Pattern {
 public:
  Pattern() {
    std::mt19937 dice(3);
    std::uniform_real_distribution<float> way(0.0F, 6.28F), length(6.0F, 25.0F);
    for (int i = 0; i < 40; ++i) {
      const float direction = way(dice), wave = 6.28F / length(dice);
      waves_.push_back({wave * std::cos(direction), wave * std::sin(direction), way(dice)});
    }
  }
  float At(float x, float y) const {
    float sum = 0.0F;
    for (const Wave& wave : waves_) sum += std::sin(wave.by_x * x + wave.by_y * y + wave.phase);
    return 128.0F + 12.0F * sum;
  }

 private:
  struct Wave {
    float by_x, by_y, phase;
  };
  std::vector<Wave> waves_;
};

constexpr int kSide = 80;
const Eigen::Vector2f kThere(40.3F, 39.6F);

struct Levels {
  std::vector<float> levels = {};
  LevelsView view() const { return {levels.data(), kSide, kSide, kSide}; }
};

struct Warp {
  float dx = 0.0F, dy = 0.0F, stretch = 0.0F, shear = 0.0F, gain = 1.0F, offset = 0.0F;
};

/// What is at kThere + (x, y) in the pattern is at kThere + d + (x + stretch x + shear y, y).
Levels Picture(const Pattern& pattern, const Warp& warp) {
  Levels picture;
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) {
      const float y = static_cast<float>(v) - kThere.y() - warp.dy;
      const float x =
          (static_cast<float>(u) - kThere.x() - warp.dx - warp.shear * y) / (1.0F + warp.stretch);
      picture.levels.push_back(warp.gain * pattern.At(kThere.x() + x, kThere.y() + y) +
                               warp.offset);
    }
  }
  return picture;
}

TEST(PatchAlign, FindsTheMiddleOfASlantedPatchInAnotherLight) {
  const Pattern pattern;
  const Levels a = Picture(pattern, {});
  for (const Warp& warp :
       {Warp{1.3F, -0.4F, 0.0F, 0.0F, 1.0F, 0.0F}, Warp{-0.7F, 0.2F, 0.2F, 0.0F, 0.7F, 10.0F},
        Warp{0.4F, 0.1F, -0.15F, 0.2F, 1.2F, -20.0F}}) {
    const Levels b = Picture(pattern, warp);
    const auto found = AlignPatch(a.view(), b.view(), kThere, kThere);
    ASSERT_TRUE(found);
    // Bilinear pictures of waves down to 6 pixels.
    EXPECT_NEAR(found->x(), kThere.x() + warp.dx, 0.02);
    EXPECT_NEAR(found->y(), kThere.y() + warp.dy, 0.02);
    const auto home = AlignPatch(b.view(), a.view(), *found, kThere);
    ASSERT_TRUE(home);
    EXPECT_NEAR(home->x(), kThere.x(), 0.03);
    EXPECT_NEAR(home->y(), kThere.y(), 0.03);
  }
}

TEST(PatchAlign, GivesNothingWhereThereIsNothingToFind) {
  const Pattern pattern;
  const Levels a = Picture(pattern, {});
  const Levels far = Picture(pattern, {.dx = 7.5F, .dy = 6.0F});
  // Not within reach, no picture about it, no pattern.
  EXPECT_FALSE(AlignPatch(a.view(), far.view(), kThere, kThere));
  EXPECT_FALSE(AlignPatch(a.view(), a.view(), {4.0F, 40.0F}, {4.0F, 40.0F}));
  EXPECT_FALSE(AlignPatch(a.view(), a.view(), kThere, {40.0F, 76.0F}));
  EXPECT_FALSE(AlignPatch(a.view(), a.view(), kThere, {NAN, 40.0F}));
  const Levels flat{std::vector<float>(a.levels.size(), 90.0F)};
  const auto nowhere = AlignPatch(flat.view(), flat.view(), kThere, kThere);
  EXPECT_TRUE(!nowhere || (*nowhere - kThere).norm() < 0.01F);
}

}  // namespace
}  // namespace kawara::vision
