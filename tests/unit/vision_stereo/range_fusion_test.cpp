#include "vision/stereo/range_fusion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <vector>

namespace kawara::vision {
namespace {

constexpr float kNan = RangeImage::kUnknown;
const Eigen::Vector3d kAhead{0.5, 0.0, 0.0}, kBehind{-0.5, 0.0, 0.0}, kNear{0.25, 0.0, 0.0};

struct Guess {
  float range_m = kNan;
  float sd_m = kNan;
  Eigen::Vector3d baseline_m = kAhead;
};

/// Every pixel the same; five wide and seven high, so that no vector is full.
RangeImage Everywhere(const Guess& guess, int width_px = 5, int height_px = 7) {
  RangeImage image;
  image.Reset(width_px, height_px);
  std::fill(image.range_m.begin(), image.range_m.end(), guess.range_m);
  std::fill(image.sd_m.begin(), image.sd_m.end(), guess.sd_m);
  return image;
}

RangeImage Fused(const std::vector<RangeImage>& images, const std::vector<Guess>& guesses,
                 const RangeFusionOptions& options = {}) {
  std::vector<RangeEstimate> estimates;
  for (std::size_t i = 0; i < images.size(); ++i)
    estimates.push_back({&images[i], guesses[i].baseline_m});
  RangeImage fused;
  FuseRanges(estimates, options, fused);
  return fused;
}

std::uint32_t Bits(float value) { return std::bit_cast<std::uint32_t>(value); }

/// What a pixel comes to; the same in all of them.
Guess OfPixel(const std::vector<Guess>& guesses, const RangeFusionOptions& options = {}) {
  std::vector<RangeImage> images;
  images.reserve(guesses.size());
  for (const Guess& guess : guesses) images.push_back(Everywhere(guess));
  const RangeImage fused = Fused(images, guesses, options);
  EXPECT_EQ(fused.width_px, 5);
  EXPECT_EQ(fused.height_px, 7);
  Guess first{fused.range_m.front(), fused.sd_m.front(), {}};
  for (std::size_t i = 0; i < fused.range_m.size(); ++i) {
    EXPECT_EQ(Bits(fused.range_m[i]), Bits(first.range_m)) << i;
    EXPECT_EQ(Bits(fused.sd_m[i]), Bits(first.sd_m)) << i;
  }
  return first;
}

TEST(RangeFusion, OneEstimateComesOutAsItIs) {
  const Guess fused = OfPixel({{4.0F, 0.03F}});
  EXPECT_EQ(fused.range_m, 4.0F);
  EXPECT_EQ(fused.sd_m, 0.03F);
}

TEST(RangeFusion, TheMeanIsOfInverseRangesByInverseVariance) {
  // Deviations of the inverse range: 0.02 / 16 and 0.04 / 16.81.
  const double w0 = 1.0 / 4.0, w1 = 1.0 / 4.1;
  const double p0 = std::pow(16.0 / 0.02, 2), p1 = std::pow(16.81 / 0.04, 2);
  const double range = (p0 + p1) / (p0 * w0 + p1 * w1);
  const Guess fused = OfPixel({{4.0F, 0.02F, kAhead}, {4.1F, 0.04F, kBehind}});
  EXPECT_NEAR(static_cast<double>(fused.range_m), range, 2e-6);
}

// Two equal estimates: (1 - a - d) / 2 of the variance, and what they share: a + d where both look
// the same way, a where from opposite ones, a + d / 2 across.
TEST(RangeFusion, WhatEstimatesShareStaysInTheDeviation) {
  RangeFusionOptions options;
  options.shared_directed = 0.3;
  options.shared_alike = 0.2;
  const auto deviation = [&](const Eigen::Vector3d& other) {
    return static_cast<double>(
        OfPixel({{4.0F, 0.02F, kAhead}, {4.0F, 0.02F, other}}, options).sd_m);
  };
  EXPECT_NEAR(deviation(kNear), 0.02 * std::sqrt(0.25 + 0.5), 1e-6);
  EXPECT_NEAR(deviation(kBehind), 0.02 * std::sqrt(0.25 + 0.2), 1e-6);
  EXPECT_NEAR(deviation({0.0, 0.5, 0.0}), 0.02 * std::sqrt(0.25 + 0.35), 1e-6);
}

TEST(RangeFusion, HoweverManyAgreeTheSharedPartRemains) {
  std::vector<Guess> guesses;
  for (std::size_t i = 0; i < kMostRangeEstimates; ++i)
    guesses.push_back({4.0F, 0.02F, i % 2 == 0 ? kAhead : kBehind});
  EXPECT_GT(OfPixel(guesses).sd_m, 0.02F * std::sqrt(0.1F));
}

TEST(RangeFusion, EstimatesThatScatterByMoreThanTheyClaimAreTrustedLess) {
  const float at_peace = OfPixel({{4.0F, 0.02F, kAhead}, {4.0F, 0.02F, kBehind}}).sd_m;
  const float in_strife = OfPixel({{4.0F, 0.02F, kAhead}, {4.08F, 0.02F, kBehind}}).sd_m;
  EXPECT_GT(in_strife, 1.5F * at_peace);
}

TEST(RangeFusion, WhatNobodyKnowsIsUnknown) {
  const Guess fused = OfPixel({{}, {}, {}});
  EXPECT_TRUE(std::isnan(fused.range_m));
  EXPECT_TRUE(std::isnan(fused.sd_m));
}

TEST(RangeFusion, ALoneEstimateStaysWithTwiceItsDeviation) {
  const Guess fused = OfPixel({{}, {4.0F, 0.02F}, {}});
  EXPECT_NEAR(fused.range_m, 4.0F, 1e-6F);
  EXPECT_NEAR(fused.sd_m, 0.04F, 1e-6F);
}

TEST(RangeFusion, ALoneEstimateThatIsNotSureIsUnknown) {
  EXPECT_TRUE(std::isnan(OfPixel({{}, {4.0F, 0.13F}}).range_m));   // 6.5 %, doubled
  EXPECT_FALSE(std::isnan(OfPixel({{}, {4.0F, 0.11F}}).range_m));  // 5.5 %
}

TEST(RangeFusion, ALoneEstimateThatIsContradictedIsUnknown) {
  EXPECT_TRUE(std::isnan(OfPixel({{4.0F, 0.02F, kAhead}, {5.0F, 0.02F, kBehind}}).range_m));
  EXPECT_TRUE(std::isnan(
      OfPixel({{4.0F, 0.001F, kAhead}, {5.0F, 0.02F, kBehind}, {2.0F, 0.02F, kNear}}).range_m));
}

TEST(RangeFusion, TheMajorityHasItsWayAndTheOtherNoPartInIt) {
  const Guess fused =
      OfPixel({{4.0F, 0.02F, kAhead}, {2.5F, 0.015F, kBehind}, {4.0F, 0.02F, kNear}});
  EXPECT_NEAR(fused.range_m, 4.0F, 1e-5F);
}

TEST(RangeFusion, TwoAgainstTwoIsUnknown) {
  EXPECT_TRUE(std::isnan(OfPixel({{4.0F, 0.02F, kAhead},
                                  {4.0F, 0.02F, kBehind},
                                  {2.5F, 0.001F, kNear},
                                  {2.5F, 0.001F, kBehind}})
                             .range_m));
}

// A chain of four, each agreeing with its neighbours only: two groups of three, of equal weight,
// about the second and about the third.
TEST(RangeFusion, InATieTheShorterBaselineDecides) {
  RangeFusionOptions options;
  options.agreement_sd = 1.0;
  const auto link = [](float inverse, const Eigen::Vector3d& baseline_m) {
    return Guess{1.0F / inverse, 0.001F / inverse / inverse, baseline_m};
  };
  const auto inverse_of = [&](const Eigen::Vector3d& second, const Eigen::Vector3d& third) {
    const Eigen::Vector3d far = 3.0 * kAhead;
    return 1.0F / OfPixel({link(0.250F, far), link(0.251F, second), link(0.252F, third),
                           link(0.253F, far)},
                          options)
                      .range_m;
  };
  EXPECT_NEAR(inverse_of(kNear, kAhead), 0.251F, 1e-5F);
  EXPECT_NEAR(inverse_of(kAhead, kNear), 0.252F, 1e-5F);
}

/// Images of random known and unknown pixels, some of them wrong.
struct Noise {
  std::vector<RangeImage> images;
  std::vector<Guess> guesses;
};
Noise RandomImages(std::size_t count) {
  std::mt19937 dice(7);
  const auto uniform = [&] { return static_cast<float>(dice()) / 4294967295.0F; };
  Noise noise;
  for (std::size_t k = 0; k < count; ++k) {
    RangeImage image;
    image.Reset(37, 11);
    for (std::size_t i = 0; i < image.range_m.size(); ++i) {
      if (uniform() < 0.3F) continue;
      image.range_m[i] = (uniform() < 0.2F ? 3.0F : 4.0F) + 0.05F * uniform();
      image.sd_m[i] = 0.01F + 0.03F * uniform();
    }
    noise.images.push_back(image);
    noise.guesses.push_back(
        {0.0F, 0.0F, Eigen::Vector3d(0.2 + 0.1 * static_cast<double>(k), 0, 0)});
  }
  return noise;
}

TEST(RangeFusion, TheOrderOfTheListDoesNotMatter) {
  Noise noise = RandomImages(5);
  const RangeImage forward = Fused(noise.images, noise.guesses);
  std::reverse(noise.images.begin(), noise.images.end());
  std::reverse(noise.guesses.begin(), noise.guesses.end());
  const RangeImage backward = Fused(noise.images, noise.guesses);
  const std::size_t bytes = forward.range_m.size() * sizeof(float);
  EXPECT_EQ(std::memcmp(forward.range_m.data(), backward.range_m.data(), bytes), 0);
  EXPECT_EQ(std::memcmp(forward.sd_m.data(), backward.sd_m.data(), bytes), 0);
}

TEST(RangeFusion, ADeviationIsKnownWhereTheRangeIs) {
  const Noise noise = RandomImages(4);
  const RangeImage fused = Fused(noise.images, noise.guesses);
  std::size_t known = 0;
  for (std::size_t i = 0; i < fused.range_m.size(); ++i) {
    EXPECT_EQ(std::isnan(fused.range_m[i]), std::isnan(fused.sd_m[i])) << i;
    if (std::isnan(fused.range_m[i])) continue;
    ++known;
    EXPECT_GT(fused.sd_m[i], 0.0F);
    EXPECT_GE(fused.range_m[i], 3.0F);
    EXPECT_LE(fused.range_m[i], 4.05F + 1e-5F);
  }
  EXPECT_GT(known, fused.range_m.size() / 2);
}

// Errors with the correlations that the options state: the fused deviation is theirs.
TEST(RangeFusion, DeviationsHoldForErrorsThatAreSharedAsStated) {
  const std::vector<Guess> places = {
      {0, 0, kAhead}, {0, 0, kBehind}, {0, 0, kNear}, {0, 0, -kNear}};
  const RangeFusionOptions options;
  const double sd[] = {0.01, 0.01, 0.02, 0.02};
  std::mt19937 dice(3);
  std::normal_distribution<double> normal;
  std::vector<RangeImage> images(4);
  for (RangeImage& image : images) image.Reset(200, 100);
  for (std::size_t i = 0; i < images[0].range_m.size(); ++i) {
    const double directed = std::sqrt(options.shared_directed) * normal(dice);
    const double alike = std::sqrt(options.shared_alike) * normal(dice);
    for (std::size_t k = 0; k < 4; ++k) {
      const double side = places[k].baseline_m.x() > 0.0 ? 1.0 : -1.0;
      const double own =
          std::sqrt(1.0 - options.shared_directed - options.shared_alike) * normal(dice);
      const double inverse = 0.25 + sd[k] / 16.0 * (side * directed + alike + own);
      images[k].range_m[i] = static_cast<float>(1.0 / inverse);
      images[k].sd_m[i] = static_cast<float>(sd[k] / 16.0 / inverse / inverse);
    }
  }
  const RangeImage fused = Fused(images, places);
  double known = 0.0, within = 0.0, square = 0.0;
  for (std::size_t i = 0; i < fused.range_m.size(); ++i) {
    if (std::isnan(fused.range_m[i])) continue;
    const double error = static_cast<double>(fused.range_m[i]) - 4.0;
    known += 1.0;
    square += error * error;
    if (std::abs(error) < 2.0 * static_cast<double>(fused.sd_m[i])) within += 1.0;
  }
  EXPECT_GT(known, 0.99 * static_cast<double>(fused.range_m.size()));
  // 0.63 / (2 / 0.01^2 + 2 / 0.02^2) and 0.1 of the weighted mean deviation's square, 0.012^2.
  EXPECT_NEAR(std::sqrt(square / known), 0.0063, 0.0003);
  EXPECT_GT(within / known, 0.94);
  EXPECT_LT(within / known, 0.985);
}

TEST(RangeFusionDeathTest, ImagesOfDifferentSizesAreABug) {
  RangeImage a = Everywhere({4.0F, 0.02F}), b = Everywhere({4.0F, 0.02F}, 7, 5), fused;
  const RangeEstimate estimates[] = {{&a, kAhead}, {&b, kBehind}};
  EXPECT_DEATH(FuseRanges(estimates, {}, fused), "CORE_CHECK");
}

TEST(RangeFusionDeathTest, NoImageIsABug) {
  RangeImage fused;
  EXPECT_DEATH(FuseRanges({}, {}, fused), "CORE_CHECK");
}

}  // namespace
}  // namespace kawara::vision
