#include "core/events.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace kawara::core {
namespace {

MonoTime At(double seconds) { return MonoTime{} + DurationFromSeconds(seconds); }

std::vector<Event> Drain(Events& events) {
  std::vector<Event> all;
  Event event;
  while (events.TryPop(event)) all.push_back(event);
  return all;
}

TEST(Events, FirstGoesThroughAtOnceThenThrottledWithCount) {
  Events events(Seconds(10));
  for (int i = 0; i < 25; ++i) events.WarnLow(At(100 + i), "gps.gap", EventText("gap ").Append(i));
  const auto all = Drain(events);
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0].stamp, At(100));
  EXPECT_EQ(all[0].suppressed, 0u);
  EXPECT_EQ(all[1].stamp, At(110));
  EXPECT_EQ(all[1].suppressed, 9u);
  EXPECT_EQ(all[2].text.view(), "gap 20");
  EXPECT_EQ(all[2].suppressed, 9u);
}

TEST(Events, FlushLetsTheLastOneOutWhenItsTimeIsOver) {
  Events events(Seconds(10));
  for (int i = 0; i < 5; ++i) events.WarnLow(At(100 + i), "gps.gap", EventText("gap ").Append(i));
  events.Flush(At(105));
  EXPECT_EQ(Drain(events).size(), 1u);
  events.Flush(At(110));
  const auto all = Drain(events);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].text.view(), "gap 4");
  EXPECT_EQ(all[0].suppressed, 3u);
  events.Flush(At(200));
  EXPECT_TRUE(Drain(events).empty());
}

TEST(Events, NamesAreThrottledApart) {
  Events events(Seconds(10));
  events.Info(At(1), "a", "x");
  events.Info(At(1), "b", "x");
  events.Info(At(2), "a", "y");
  EXPECT_EQ(Drain(events).size(), 2u);
}

TEST(Events, SameTextAtAnotherAddressIsTheSameName) {
  static const char name_1[] = "gps.gap";
  static const char name_2[] = "gps.gap";
  Events events(Seconds(10));
  events.Info(At(1), name_1, "x");
  events.Info(At(2), name_2, "x");
  EXPECT_EQ(Drain(events).size(), 1u);
}

TEST(Events, WorseAndFatalAreNotHeldBack) {
  Events events(Seconds(10));
  events.WarnLow(At(1), "disk", "80 %");
  events.WarnHigh(At(2), "disk", "95 %");
  events.WarnHigh(At(3), "disk", "96 %");
  events.Fatal(At(4), "disk", "full");
  events.Fatal(At(5), "disk", "still full");
  const auto all = Drain(events);
  ASSERT_EQ(all.size(), 4u);
  EXPECT_EQ(all[1].severity, Severity::kWarnHigh);
  EXPECT_EQ(all[2].suppressed, 1u);
  EXPECT_EQ(all[3].text.view(), "still full");
}

TEST(Events, TimeRunningBackwardsOpensTheThrottle) {
  Events events(Seconds(10));
  events.Info(At(1000), "a", "x");
  events.Info(At(5), "a", "y");
  EXPECT_EQ(Drain(events).size(), 2u);
}

TEST(Events, LongTextIsCut) {
  Events events;
  events.Info(At(1), "a", std::string_view(std::string(500, 'x')));
  const auto all = Drain(events);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].text.size(), 200u);
}

TEST(Events, NobodyDrainingLosesTheOldestAndCounts) {
  Events events(Duration(0));
  for (int i = 0; i < 300; ++i) events.Info(At(i + 1), "a", EventText().Append(i));
  EXPECT_EQ(events.dropped(), 44u);
  const auto all = Drain(events);
  ASSERT_EQ(all.size(), 256u);
  EXPECT_EQ(all.front().text.view(), "44");
}

TEST(Events, MoreNamesThanTheTableHoldsShareOneEntry) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < Events::kMaxNames + 20; ++i) names.push_back("n" + std::to_string(i));
  Events events(Seconds(10));
  for (const std::string& name : names) events.Info(At(1), name.c_str(), "x");
  EXPECT_EQ(Drain(events).size(), Events::kMaxNames);
}

TEST(FixedText, NumbersNeedNoPrintf) {
  EXPECT_EQ(FixedText<40>("t ").Append(-12).Append(" ").Append(1.25, 1).view(), "t -12 1.2");
  EXPECT_EQ(FixedText<80>().Append(1e300, 3).view(), "1e+300");
  EXPECT_EQ(FixedText<3>("abcdef").view(), "abc");
}

}  // namespace
}  // namespace kawara::core
