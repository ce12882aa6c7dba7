#include "onboard/event_marks.hpp"

#include <gtest/gtest.h>

namespace kawara::onboard {
namespace {

core::GpsTime At(double seconds) {
  return core::GpsTime::FromNs(1'000'000'000'000'000'000) + core::DurationFromSeconds(seconds);
}
constexpr core::Duration kWindow = core::Milliseconds(50);

TEST(EventMarks, AnExposureFindsItsOwnByTimeWhateverWasLost) {
  EventMarks marks;
  marks.OnMark(At(1.001));
  // The second one was never told of.
  marks.OnMark(At(3.001));
  EXPECT_EQ(marks.Take(At(1.0), kWindow), At(1.001));
  EXPECT_FALSE(marks.Take(At(2.0), kWindow));
  EXPECT_EQ(marks.Take(At(3.0), kWindow), At(3.001));
  EXPECT_EQ(marks.stats().used, 2);
}

TEST(EventMarks, EachIsGivenAwayOnceAndTheNearestFirst) {
  EventMarks marks;
  marks.OnMark(At(1.030));
  marks.OnMark(At(1.002));
  EXPECT_EQ(marks.Take(At(1.0), kWindow), At(1.002));
  EXPECT_EQ(marks.Take(At(1.0), kWindow), At(1.030));
  EXPECT_FALSE(marks.Take(At(1.0), kWindow));
}

TEST(EventMarks, OneThatNobodyWasNearIsStrayOnceItIsForgotten) {
  EventMarks marks;
  for (int i = 0; i < 20; ++i) marks.OnMark(At(i));
  EXPECT_EQ(marks.stats().stray, 4);
  EXPECT_FALSE(marks.Take(At(2.0), kWindow));
  EXPECT_TRUE(marks.Take(At(10.0), kWindow));
}

TEST(EventMarks, ADeadWireIsToldOnceAndNotWaitedForUntilItLives) {
  EventMarks marks;
  int told = 0;
  for (int i = 0; i < 12; ++i) told += marks.Miss() ? 1 : 0;
  EXPECT_EQ(told, 1);
  EXPECT_FALSE(marks.alive());
  marks.OnMark(At(1.0));
  EXPECT_TRUE(marks.Take(At(1.0), kWindow));
  EXPECT_TRUE(marks.alive());
  EXPECT_EQ(marks.stats().missing, 12);
}

}  // namespace
}  // namespace kawara::onboard
