#include "sim/render/noise2.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>

#include "sim/dice.hpp"

namespace kawara::sim {
namespace {

TEST(Noise2, IsContinuousAndWithinOne) {
  Dice dice(1);
  for (int i = 0; i < 5000; ++i) {
    const auto x = static_cast<float>(200.0 * dice.Uniform() - 100.0);
    const auto y = static_cast<float>(200.0 * dice.Uniform() - 100.0);
    const float here = Noise2(x, y, 3);
    EXPECT_LE(std::abs(here), 1.0F);
    EXPECT_NEAR(here, Noise2(x + 0.001F, y, 3), 0.005F);
    EXPECT_NEAR(here, Noise2(x, y + 0.001F, 3), 0.005F);
  }
}

TEST(Noise2, ASumOfOctavesIsTheSumOfItsOctaves) {
  Dice dice(2);
  for (int i = 0; i < 2000; ++i) {
    const auto u = static_cast<float>(40.0 * dice.Uniform() - 20.0);
    const auto v = static_cast<float>(40.0 * dice.Uniform() - 20.0);
    const auto footprint = static_cast<float>(std::pow(10.0, -3.0 + 3.0 * dice.Uniform()));
    float expected = 0.0F;
    for (int k = 0; k < 6; ++k) {
      const float wavelength = 0.5F * std::pow(0.5F, static_cast<float>(k));
      expected += std::pow(0.7F, static_cast<float>(k)) * DetailLeft(wavelength, footprint) *
                  Noise2(u / wavelength, v / wavelength, 9U + 131U * static_cast<std::uint32_t>(k));
    }
    EXPECT_NEAR(Fractal2(u, v, 0.5F, 6, 0.7F, footprint, 9U), expected, 2e-4F);
  }
}

// Pictures must not depend on the machine that renders them.
TEST(Noise2, EverySimdTargetGivesTheSameBits) {
  const auto sample = [] {
    std::vector<float> values;
    Dice dice(3);
    for (int i = 0; i < 500; ++i) {
      const auto u = static_cast<float>(40.0 * dice.Uniform() - 20.0);
      const auto v = static_cast<float>(40.0 * dice.Uniform() - 20.0);
      values.push_back(Fractal2(u, v, 1.3F, 8, 0.8F, 0.003F, 5U));
    }
    return values;
  };
  const std::vector<float> best = sample();
  int targets = 0;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    EXPECT_EQ(sample(), best) << hwy::TargetName(target);
    ++targets;
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  EXPECT_GT(targets, 0);
}

}  // namespace
}  // namespace kawara::sim
