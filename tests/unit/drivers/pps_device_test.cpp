#include "drivers/pps_device.hpp"

#include <gtest/gtest.h>

#include <string>

namespace kawara::drivers {
namespace {

ClockPair Pair(std::int64_t realtime_ns, std::int64_t mono_ns) {
  return {realtime_ns, core::MonoTime::FromNs(mono_ns)};
}

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kWall = 1'800'000'000 * kSecond;

TEST(OnMonotonic, IsAsLongAgoOnBothClocks) {
  const ClockPair before = Pair(kWall, 50 * kSecond);
  const ClockPair now = Pair(kWall + kSecond / 5, 50 * kSecond + kSecond / 5);
  const auto mono = OnMonotonic(kWall + 100'000'000, before, now);
  ASSERT_TRUE(mono);
  EXPECT_EQ(mono->ns(), 50 * kSecond + 100'000'000);
}

TEST(OnMonotonic, FollowsAClockThatIsSlewed) {
  const ClockPair before = Pair(kWall, 50 * kSecond);
  const ClockPair now = Pair(kWall + kSecond / 5 + 16'000'000, 50 * kSecond + kSecond / 5);
  const auto mono = OnMonotonic(now.realtime_ns - 50'000, before, now);
  ASSERT_TRUE(mono);
  EXPECT_EQ(mono->ns(), now.mono.ns() - 50'000);
}

TEST(OnMonotonic, RefusesAStampIfTheClockWasSetMeanwhile) {
  const ClockPair before = Pair(kWall, 50 * kSecond);
  for (const std::int64_t step : {kSecond, -kSecond, 30'000'000L, -3600 * kSecond}) {
    const ClockPair now = Pair(kWall + kSecond / 5 + step, 50 * kSecond + kSecond / 5);
    EXPECT_FALSE(OnMonotonic(kWall + 100'000'000, before, now)) << step;
  }
}

TEST(OnMonotonic, RefusesTheFuture) {
  const ClockPair now = Pair(kWall, 50 * kSecond);
  EXPECT_FALSE(OnMonotonic(kWall + 1, now, now));
}

TEST(ClockPair, ReadsBothClocks) {
  const core::MonoTime before = core::MonoNow();
  const ClockPair pair = ClockPair::Read();
  EXPECT_GE(pair.mono, before);
  EXPECT_LE(pair.mono, core::MonoNow());
  EXPECT_GT(pair.realtime_ns, 1'600'000'000 * kSecond);
}

TEST(KernelPps, SaysWhatIsNoPulseDevice) {
  const std::pair<const char*, const char*> cases[] = {
      {"/dev/pps-none", "no such device (is its driver loaded"},
      {"/dev/null", "not a PPS device"},
      {"/tmp", "directory"},
  };
  for (const auto& [path, part] : cases) {
    KernelPps pps(path, PulseEdge::kRising);
    const auto edge = pps.Next(core::Milliseconds(1));
    ASSERT_FALSE(edge) << path;
    EXPECT_NE(edge.error().message.find(part), std::string::npos) << edge.error().message;
    EXPECT_NE(edge.error().message.find(path), std::string::npos) << edge.error().message;
  }
}

}  // namespace
}  // namespace kawara::drivers
