#include "vision/calibration/coverage.hpp"

#include <gtest/gtest.h>

#include "core/geodesy.hpp"

namespace kawara::vision {
namespace {

/// Corners in every cell but those between two hours of a clock.
BoardView AllBut(double from_hour, double to_hour) {
  BoardView view;
  for (int half = 0; half < 24; ++half) {
    const double hour = 0.25 + 0.5 * half;
    if (hour > from_hour && hour < to_hour) continue;
    const double turn = 2.0 * core::kPi * (hour - 3.0) / 12.0;
    for (int r = 5; r < 100; r += 5) {
      view.push_back({0, 0, Eigen::Vector2d(200 + r * std::cos(turn), 200 + r * std::sin(turn))});
    }
  }
  return view;
}

TEST(Coverage, SaysAtWhichHoursThePictureIsEmpty) {
  const auto hours = [](const BoardView& view) {
    return CoverageOf({view}, {200, 200}, 100).EmptyHours();
  };
  EXPECT_EQ(hours(AllBut(0, 0)), "");
  EXPECT_EQ(hours(AllBut(0, 1)), "12-1 o'clock");
  EXPECT_EQ(hours(AllBut(2, 5)), "2-5 o'clock");
  EXPECT_EQ(hours(AllBut(9, 12)), "9-12 o'clock");
  BoardView beside = AllBut(2, 12);
  EXPECT_EQ(hours(beside), "2-12 o'clock");
}

TEST(Coverage, CountsCellsFromTheInnermostCornerOutwards) {
  const Coverage half = CoverageOf({AllBut(0, 6)}, {200, 200}, 100);
  EXPECT_NEAR(half.CellShare(), 0.5, 0.01);
  EXPECT_NEAR(half.RadiusShare(), 90.0 / 95.0, 0.01);
}

}  // namespace
}  // namespace kawara::vision
