#include "onboard/mapper/report/error_histogram.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace kawara::mapper {
namespace {

constexpr double kBinM = 1e-3;

ErrorHistogram Of(std::initializer_list<double> errors_m) {
  ErrorHistogram histogram;
  for (const double error : errors_m) histogram.Add(error);
  return histogram;
}

TEST(ErrorHistogram, OfNothingThereIsNoMedian) {
  EXPECT_TRUE(std::isnan(ErrorHistogram().MedianSizeM()));
  EXPECT_EQ(ErrorHistogram().total(), 0U);
}

TEST(ErrorHistogram, TheMedianIsOfSizesWhateverTheSign) {
  EXPECT_NEAR(Of({-0.0105, 0.0205, -0.0305, 0.0405, -0.0505}).MedianSizeM(), 0.0305, kBinM);
  EXPECT_NEAR(Of({-0.0305, -0.0305, -0.0305}).MedianSizeM(), 0.0305, kBinM);
  EXPECT_NEAR(Of({0.0305, 0.0305, 0.0305}).MedianSizeM(), 0.0305, kBinM);
}

TEST(ErrorHistogram, CountsHalfOpenIntervals) {
  const ErrorHistogram histogram = Of({-0.0025, -0.0005, 0.0005, 0.0015, 0.0025});
  EXPECT_EQ(histogram.Count(-3, -1), 1U);
  EXPECT_EQ(histogram.Count(-1, 0), 1U);
  EXPECT_EQ(histogram.Count(0, 2), 2U);
  EXPECT_EQ(histogram.Count(-4000, 4000), 5U);
  EXPECT_EQ(histogram.Count(2, 2), 0U);
  EXPECT_EQ(histogram.Count(5, -5), 0U);
}

TEST(ErrorHistogram, ErrorsOfAnySizeAreCounted) {
  const ErrorHistogram histogram = Of({1e9, -1e9, INFINITY, -INFINITY, 0.0});
  EXPECT_EQ(histogram.total(), 5U);
  EXPECT_EQ(histogram.Count(-ErrorHistogram::kLimitMm, ErrorHistogram::kLimitMm), 1U);
  EXPECT_DOUBLE_EQ(histogram.MedianSizeM(), 4.0);
}

TEST(ErrorHistogram, SumOfTwoIsThatOfAllErrors) {
  ErrorHistogram sum = Of({0.0105, 5.0});
  sum.Add(Of({-0.0105, -0.0205, -5.0}));
  EXPECT_EQ(sum.total(), 5U);
  EXPECT_EQ(sum.Count(-21, 11), 3U);
  EXPECT_NEAR(sum.MedianSizeM(), 0.0205, kBinM);
}

TEST(ErrorHistogram, ShareOfTheErrors) {
  ErrorHistogram histogram;
  for (int mm = 0; mm < 100; ++mm) histogram.Add(1e-3 * (mm + 0.5));
  EXPECT_EQ(histogram.SizeOfShareMm(0.5), 50);
  EXPECT_EQ(histogram.SizeOfShareMm(1.0), 100);
  EXPECT_EQ(histogram.SizeOfShareMm(0.0), 0);
}

}  // namespace
}  // namespace kawara::mapper
