#include "onboard/mapper/report/accuracy.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace kawara::mapper {
namespace {

constexpr double kFloatM = 1e-6;     // of ranges kept as floats
constexpr double kMedianM = 1.5e-3;  // 1.4826 times a bin

struct Pixel {
  float truth_m, range_m, sd_m;
};

constexpr float kNan = vision::RangeImage::kUnknown;

void AddTo(Accuracy& accuracy, const std::vector<Pixel>& pixels,
           const std::vector<std::uint8_t>& counted = {}) {
  vision::RangeImage image;
  image.Reset(static_cast<int>(pixels.size()), 1);
  std::vector<float> truth;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    truth.push_back(pixels[i].truth_m);
    image.range_m[i] = pixels[i].range_m;
    image.sd_m[i] = pixels[i].sd_m;
  }
  accuracy.Add(image, truth, counted);
}

Accuracy Of(const std::vector<Pixel>& pixels) {
  Accuracy accuracy;
  AddTo(accuracy, pixels);
  return accuracy;
}

/// Errors at 3 m, by hand: +30, -10, +40, -20 mm, one of +600 mm (20 %), one pixel not measured.
/// Within 10 %: mean 10 mm, mean square (900 + 100 + 1600 + 400) / 4 = 750, variance 650 mm2.
/// Sizes 10 20 30 40 600: median 30. Below twice 18 mm: three of five.
const std::vector<Pixel> kByHand{{3.0F, 3.0305F, 0.018F}, {3.0F, 2.9895F, 0.018F},
                                 {3.0F, 3.0405F, 0.018F}, {3.0F, 2.9795F, 0.018F},
                                 {3.0F, 3.6F, 0.018F},    {3.0F, kNan, kNan}};

TEST(Accuracy, KnownAnswer) {
  const AccuracyFigures f = Of(kByHand).Figures(1, 1);
  EXPECT_EQ(f.wanted, 6U);
  EXPECT_EQ(f.known, 5U);
  EXPECT_NEAR(f.bias_m, 0.010, kFloatM);  // (30.5 - 10.5 + 40.5 - 20.5) / 4
  // Mean square (930.25 + 110.25 + 1640.25 + 420.25) / 4 = 775.25, less 10 squared.
  EXPECT_NEAR(f.std_m, std::sqrt(675.25e-6), kFloatM);
  EXPECT_NEAR(f.nmad_m, 1.4826 * 0.0305, kMedianM);
  EXPECT_DOUBLE_EQ(f.outliers, 1.0 / 5.0);
  EXPECT_DOUBLE_EQ(f.density, 5.0 / 6.0);
  EXPECT_DOUBLE_EQ(f.within_2_sd, 3.0 / 5.0);
}

TEST(Accuracy, OfNothingThereAreNoFigures) {
  const AccuracyFigures f = Accuracy().Figures(0, Accuracy::kBands - 1);
  EXPECT_EQ(f.wanted, 0U);
  for (const double value : {f.std_m, f.nmad_m, f.bias_m, f.outliers, f.density, f.within_2_sd}) {
    EXPECT_TRUE(std::isnan(value));
  }
}

TEST(Accuracy, NothingMeasuredIsDensityZeroAndNoError) {
  const AccuracyFigures f = Of({{3.0F, kNan, kNan}, {3.0F, kNan, kNan}}).Figures(1, 1);
  EXPECT_DOUBLE_EQ(f.density, 0.0);
  EXPECT_TRUE(std::isnan(f.std_m));
  EXPECT_TRUE(std::isnan(f.outliers));
}

TEST(Accuracy, PixelsWithoutTruthDoNotCount) {
  const Accuracy accuracy = Of({{0.0F, 3.0F, 0.1F},
                                {kNan, 3.0F, 0.1F},
                                {INFINITY, 3.0F, 0.1F},
                                {-1.0F, 3.0F, 0.1F},
                                {3.0F, 3.0F, 0.1F}});
  EXPECT_EQ(accuracy.Figures(0, Accuracy::kBands - 1).wanted, 1U);
}

TEST(Accuracy, BandsAreOfTheTruthAndHalfOpen) {
  const struct {
    float truth_m;
    std::size_t band;
  } cases[]{{0.5F, 0}, {1.999F, 0}, {2.0F, 1}, {3.999F, 1}, {4.0F, 2},
            {6.0F, 3}, {7.999F, 3}, {8.0F, 4}, {60.0F, 4}};
  for (const auto& [truth_m, band] : cases) {
    const Accuracy accuracy = Of({{truth_m, 5.0F, 0.1F}});
    for (std::size_t i = 0; i < Accuracy::kBands; ++i) {
      EXPECT_EQ(accuracy.Figures(i, i).wanted, i == band ? 1U : 0U) << truth_m << " band " << i;
    }
  }
}

TEST(Accuracy, BandsTogetherAreThePixelsTogether) {
  Accuracy accuracy = Of(kByHand);
  AddTo(accuracy, {{5.0F, 5.0505F, 0.1F}});
  const AccuracyFigures f = accuracy.Figures(1, 2);
  EXPECT_EQ(accuracy.images(), 2U);
  EXPECT_EQ(f.known, 6U);
  EXPECT_NEAR(f.bias_m, (4 * 0.010 + 0.0505) / 5, kFloatM);
  EXPECT_EQ(accuracy.Errors(1, 2).total(), 6U);
  EXPECT_EQ(accuracy.Errors(1, 2).Count(50, 51), 1U);
}

TEST(Accuracy, OnlyCountedPixelsAreJudged) {
  Accuracy accuracy;
  AddTo(accuracy, kByHand, {1, 0, 0, 0, 0, 1});
  EXPECT_EQ(accuracy.Figures(1, 1).wanted, 2U);
  EXPECT_NEAR(accuracy.Figures(1, 1).bias_m, 0.0305, kFloatM);
}

TEST(Accuracy, FromTenPercentOfTheTruthOnAnErrorIsAnOutlier) {
  EXPECT_DOUBLE_EQ(Of({{4.0F, 4.39F, 0.1F}}).Figures(2, 2).outliers, 0.0);
  EXPECT_DOUBLE_EQ(Of({{4.0F, 4.41F, 0.1F}}).Figures(2, 2).outliers, 1.0);
  EXPECT_DOUBLE_EQ(Of({{4.0F, 3.59F, 0.1F}}).Figures(2, 2).outliers, 1.0);
}

}  // namespace
}  // namespace kawara::mapper
