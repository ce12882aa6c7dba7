#include "onboard/fix_patience.hpp"

#include <gtest/gtest.h>

namespace kawara::onboard {
namespace {

void AddMany(FixPatience& patience, core::Duration latency, int n) {
  for (int i = 0; i < n; ++i) patience.Add(latency);
}

TEST(FixPatience, WaitsLongestBeforeThereIsExperience) {
  FixPatience patience;
  AddMany(patience, core::Milliseconds(80), 19);
  EXPECT_EQ(patience.Get(), FixPatience::kMost);
}

TEST(FixPatience, IsHalfAsMuchAgainAsTheSlowestFix) {
  FixPatience patience;
  AddMany(patience, core::Milliseconds(80), 19);
  patience.Add(core::Milliseconds(120));
  EXPECT_EQ(patience.Get(), core::Milliseconds(180));
}

TEST(FixPatience, ForgetsTheSlowestFixInTime) {
  FixPatience patience;
  patience.Add(core::Milliseconds(200));
  AddMany(patience, core::Milliseconds(80), 20);
  EXPECT_EQ(patience.Get(), core::Milliseconds(120));
}

TEST(FixPatience, StaysWithinReason) {
  FixPatience patience;
  AddMany(patience, core::Milliseconds(-5), 20);  // a clock that is still finding itself
  EXPECT_EQ(patience.Get(), FixPatience::kLeast);
  AddMany(patience, core::Seconds(2), 20);
  EXPECT_EQ(patience.Get(), FixPatience::kMost);
}

}  // namespace
}  // namespace kawara::onboard
