#include "onboard/baud_finder.hpp"

#include <gtest/gtest.h>

#include <set>

namespace kawara::onboard {
namespace {

core::MonoTime At(double seconds) {
  return core::MonoTime::FromNs(1'000'000'000) + core::DurationFromSeconds(seconds);
}

TEST(BaudFinder, StaysWhileMessagesCome) {
  BaudFinder finder(115200, core::Seconds(3));
  finder.Start(At(0));
  finder.OnBytes(5000);
  finder.OnMessage();
  EXPECT_EQ(finder.Tick(At(100), true), BaudFinder::Advice::kStay);
  EXPECT_EQ(finder.current(), 115200);
}

TEST(BaudFinder, GarbageLeadsToTheNextRateAfterItsPatience) {
  BaudFinder finder(115200, core::Seconds(3));
  finder.Start(At(0));
  finder.OnBytes(5000);
  EXPECT_EQ(finder.Tick(At(2.9), false), BaudFinder::Advice::kStay);
  EXPECT_EQ(finder.Tick(At(3.1), false), BaudFinder::Advice::kTryNext);
  EXPECT_NE(finder.current(), 115200);
}

TEST(BaudFinder, SilenceSpeaksAgainstTheRateOnlyWhereAnAnswerWasExpected) {
  BaudFinder finder(115200, core::Seconds(3));
  finder.Start(At(0));
  EXPECT_EQ(finder.Tick(At(10), false), BaudFinder::Advice::kStay);
  EXPECT_EQ(finder.Tick(At(10), true), BaudFinder::Advice::kTryNext);
}

TEST(BaudFinder, TriesEachRateOnceBeforeItIsExhausted) {
  BaudFinder finder(9600, core::Seconds(3));
  finder.Start(At(0));
  std::set<int> tried{finder.current()};
  double t = 0;
  while (!finder.exhausted()) {
    t += 4;
    ASSERT_EQ(finder.Tick(At(t), true), BaudFinder::Advice::kTryNext);
    const bool is_new = tried.insert(finder.current()).second;
    EXPECT_NE(is_new, finder.exhausted()) << finder.current();
    ASSERT_LT(t, 100);
  }
  EXPECT_EQ(finder.current(), 9600);
  EXPECT_TRUE(tried.contains(115200) && tried.contains(38400) && tried.contains(4800));
}

}  // namespace
}  // namespace kawara::onboard
