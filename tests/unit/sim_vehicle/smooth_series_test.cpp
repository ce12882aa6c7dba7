#include "sim/vehicle/smooth_series.hpp"

#include <gtest/gtest.h>

#include "sim/dice.hpp"

namespace kawara::sim {
namespace {

SmoothSeries Rough() {
  Dice dice(4);
  std::vector<double> values(60);
  for (double& v : values) v = dice.Normal();
  return {values, 0.25};
}

TEST(SmoothSeries, DerivativesFitEachOtherEverywhereAlsoAtTheKnots) {
  const SmoothSeries series = Rough();
  constexpr double kStep = 1e-4;
  for (double x = -1.0; x < 17.0; x += 0.125) {
    const SmoothSeries::Jet a = series.At(x - kStep);
    const SmoothSeries::Jet b = series.At(x);
    const SmoothSeries::Jet c = series.At(x + kStep);
    for (std::size_t d = 0; d < 3; ++d)
      ASSERT_NEAR((c[d] - a[d]) / (2.0 * kStep), b[d + 1], 1e-3) << x << " " << d;
  }
}

TEST(SmoothSeries, KeepsStraightRowsAndRest) {
  std::vector<double> line;
  for (int i = 0; i < 20; ++i) line.push_back(3.0 - 0.7 * i);
  const SmoothSeries series(line, 0.5);
  for (double x = 1.5; x < 7.9; x += 0.1) {
    EXPECT_NEAR(series.At(x)[0], 3.0 - 1.4 * x, 1e-12);
    EXPECT_NEAR(series.At(x)[1], -1.4, 1e-12);
    EXPECT_NEAR(series.At(x)[2], 0.0, 1e-10);
  }
  const SmoothSeries rest(std::vector<double>(9, 0.1), 0.5);
  for (double x = -3.0; x < 9.0; x += 0.17) {
    EXPECT_EQ(rest.At(x)[0], 0.1) << "exactly, no rounding";
    EXPECT_EQ(rest.At(x)[1], 0.0);
  }
}

TEST(SmoothSeries, NeverOvershoots) {
  std::vector<double> step(20, 0.0);
  for (std::size_t i = 10; i < 20; ++i) step[i] = 1.0;
  const SmoothSeries series(step, 1.0);
  double last = 0.0;
  for (double x = -2.0; x < 25.0; x += 0.01) {
    const double y = series.At(x)[0];
    ASSERT_GE(y, last - 1e-15);
    ASSERT_LE(y, 1.0);
    last = y;
  }
  EXPECT_EQ(series.At(6.4)[0], 0.0) << "a step is felt three pitches around, no further";
  EXPECT_EQ(series.At(13.0)[0], 1.0);
}

}  // namespace
}  // namespace kawara::sim
