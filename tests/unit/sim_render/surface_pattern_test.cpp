#include "sim/render/surface_pattern.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <string>

#include "sim/dice.hpp"

namespace kawara::sim {
namespace {

const std::vector<std::pair<Pattern, std::string>> kAll = {
    {Pattern::kPlain, "plain"},       {Pattern::kAsphalt, "asphalt"},
    {Pattern::kConcrete, "concrete"}, {Pattern::kBrick, "brick"},
    {Pattern::kTiles, "tiles"},       {Pattern::kCorrugated, "corrugated"},
    {Pattern::kGlass, "glass"},       {Pattern::kWood, "wood"},
    {Pattern::kSoil, "soil"},         {Pattern::kGrass, "grass"},
    {Pattern::kLeaves, "leaves"},     {Pattern::kRubble, "rubble"},
    {Pattern::kCloth, "cloth"}};

Material Of(Pattern pattern) {
  Material material;
  material.pattern = pattern;
  material.base_rgb = {0.30F, 0.25F, 0.20F};
  material.second_rgb = {0.40F, 0.38F, 0.35F};
  material.scale_m = 0.2F;
  material.seed = 5;
  return material;
}

SurfacePoint At(double u, double v, double footprint) {
  SurfacePoint point;
  point.uv_m = Eigen::Vector2d(u, v).cast<float>();
  point.footprint_u_m = point.footprint_v_m = static_cast<float>(footprint);
  return point;
}

/// Mean and deviation of the colour's mean over a patch.
std::pair<double, double> Look(const Material& material, double footprint, double size_m = 8.0) {
  Dice dice(3);
  double sum = 0.0;
  double squares = 0.0;
  constexpr int kSamples = 4000;
  for (int i = 0; i < kSamples; ++i) {
    const double grey = static_cast<double>(
        ColourOf(material, At(size_m * dice.Uniform(), size_m * dice.Uniform(), footprint))
            .rgb.mean());
    sum += grey;
    squares += grey * grey;
  }
  const double mean = sum / kSamples;
  return {mean, std::sqrt(std::max(0.0, squares / kSamples - mean * mean))};
}

TEST(SurfacePattern, EveryColourIsAReflectance) {
  for (const auto& [pattern, name] : kAll) {
    Material material = Of(pattern);
    material.contrast = 2.0F;
    Dice dice(8);
    for (int i = 0; i < 3000; ++i) {
      const auto colour =
          ColourOf(material, At(40.0 * dice.Uniform() - 20.0, 40.0 * dice.Uniform() - 20.0,
                                std::pow(10.0, -3.0 + 4.0 * dice.Uniform())));
      ASSERT_TRUE((colour.rgb >= 0.0F).all() && (colour.rgb <= 1.0F).all()) << name;
      ASSERT_TRUE(std::isfinite(colour.slope_u) && std::isfinite(colour.slope_v)) << name;
    }
  }
}

TEST(SurfacePattern, RichOnesVaryAndPlainOnesHardlyDo) {
  EXPECT_LT(Look(Of(Pattern::kPlain), 0.003).second, 0.01 * Look(Of(Pattern::kPlain), 0.003).first);
  for (const Pattern rich : {Pattern::kAsphalt, Pattern::kConcrete, Pattern::kBrick, Pattern::kSoil,
                             Pattern::kGrass, Pattern::kLeaves, Pattern::kRubble}) {
    const auto [mean, deviation] = Look(Of(rich), 0.003);
    EXPECT_GT(deviation, 0.06 * mean) << static_cast<int>(rich);
  }
}

TEST(SurfacePattern, FromAfarDetailsMeltIntoTheirMean) {
  for (const auto& [pattern, name] : kAll) {
    if (pattern == Pattern::kGlass) continue;  // curtains are a metre wide
    const auto [near_mean, near_deviation] = Look(Of(pattern), 0.003);
    const auto [far_mean, far_deviation] = Look(Of(pattern), 6.0);
    EXPECT_LE(far_deviation, 0.5 * near_deviation + 1e-4) << name;
    EXPECT_NEAR(far_mean, near_mean, 0.20 * near_mean) << name;
  }
}

TEST(SurfacePattern, WhatIsSeenAtOnePixelsDistanceIsAlmostTheSame) {
  // Band limit: half a footprint on, the colour has changed by a part of its contrast only.
  for (const auto& [pattern, name] : kAll) {
    const Material material = Of(pattern);
    for (const double footprint : {0.01, 0.05, 0.3}) {
      Dice dice(11);
      double change = 0.0;
      double contrast = 0.0;
      for (int i = 0; i < 2000; ++i) {
        const double u = 8.0 * dice.Uniform();
        const double v = 8.0 * dice.Uniform();
        const auto grey = [&](double x, double y) {
          return static_cast<double>(ColourOf(material, At(x, y, footprint)).rgb.mean());
        };
        change += std::pow(grey(u, v) - grey(u + 0.25 * footprint, v), 2);
        contrast += std::pow(grey(u, v) - grey(u + 3.1, v + 2.3), 2);
      }
      EXPECT_LT(std::sqrt(change), 0.55 * std::sqrt(contrast) + 0.002 * std::sqrt(2000.0))
          << name << " " << footprint;
    }
  }
}

TEST(SurfacePattern, SeedsMakeDifferentSurfacesAndTheSameSeedTheSame) {
  for (const auto& [pattern, name] : kAll) {
    const Material a = Of(pattern);
    Material b = a;
    b.seed = 6;
    double same = 0.0;
    double other = 0.0;
    Dice dice(2);
    for (int i = 0; i < 500; ++i) {
      const SurfacePoint point = At(8.0 * dice.Uniform(), 8.0 * dice.Uniform(), 0.004);
      same += static_cast<double>((ColourOf(a, point).rgb - ColourOf(a, point).rgb).abs().sum());
      other += static_cast<double>((ColourOf(a, point).rgb - ColourOf(b, point).rgb).abs().sum());
    }
    EXPECT_EQ(same, 0.0) << name;
    EXPECT_GT(other, 0.0) << name;
  }
}

// Pictures must not depend on the machine, nor on which pixels are computed together.
TEST(SurfacePattern, EverySimdTargetAndEveryLaneGivesTheSameBits) {
  const auto sample = [](std::size_t count) {
    std::vector<float> values;
    for (const auto& [pattern, name] : kAll) {
      Dice dice(4);
      for (std::size_t first = 0; first < 96; first += count) {
        SurfacePoints points;
        for (std::size_t i = 0; i < count; ++i) {
          points.u_m[i] = static_cast<float>(40.0 * dice.Uniform() - 20.0);
          points.v_m[i] = static_cast<float>(40.0 * dice.Uniform() - 20.0);
          points.footprint_u_m[i] = static_cast<float>(std::pow(10.0, -3.0 + 3.0 * dice.Uniform()));
          points.footprint_v_m[i] = 0.7F * points.footprint_u_m[i];
        }
        SurfaceColours colours;
        ColoursOf(Of(pattern), points, count, colours);
        for (std::size_t i = 0; i < count; ++i) {
          values.insert(values.end(), {colours.red[i], colours.blue[i], colours.slope_u[i],
                                       colours.slope_v[i], colours.gloss[i]});
        }
      }
    }
    return values;
  };
  const std::vector<float> best = sample(16);
  for (const std::size_t count : {1U, 3U, 8U}) EXPECT_EQ(sample(count), best) << count;
  int targets = 0;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    EXPECT_EQ(sample(16), best) << hwy::TargetName(target);
    ++targets;
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  EXPECT_GT(targets, 0);
}

TEST(SurfacePattern, BrickCoursesRepeatAtTheirHeight) {
  Material material = Of(Pattern::kBrick);
  material.contrast = 1.0F;
  // Mortar (light) lies at whole courses, brick (dark) between them.
  for (int course = 1; course < 20; ++course) {
    const double joint =
        static_cast<double>(ColourOf(material, At(0.33, 0.2 * course, 0.002)).rgb.mean());
    const double face =
        static_cast<double>(ColourOf(material, At(0.33, 0.2 * (course + 0.5), 0.002)).rgb.mean());
    EXPECT_GT(joint, face) << course;
  }
}

}  // namespace
}  // namespace kawara::sim
