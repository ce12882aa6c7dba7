#include "drivers/v4l2_stamps.hpp"

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <limits>
#include <random>

namespace kawara::drivers {
namespace {

constexpr std::uint32_t kMonotonic = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
const core::MonoTime kBegin = core::MonoTime::FromNs(5'000'000'000'000);

/// A stamp in the two numbers of the kernel. Whole microseconds.
V4l2StampClock::Stamp Take(V4l2StampClock& clock, std::int64_t stamp_ns, std::uint32_t flags,
                           core::MonoTime arrival, const V4l2StampRule& rule = {}) {
  std::int64_t seconds = stamp_ns / 1'000'000'000, rest = stamp_ns % 1'000'000'000;
  if (rest < 0) rest += 1'000'000'000, --seconds;
  return clock.Take(seconds, rest / 1000, flags, arrival, rule);
}

TEST(V4l2Stamps, MonotonicIsBelievedAndSetBackByWhatItStamps) {
  const V4l2StampRule rule{core::Milliseconds(8), core::Milliseconds(20)};
  struct {
    std::uint32_t source;
    core::Duration back;
  } const cases[] = {{V4L2_BUF_FLAG_TSTAMP_SRC_EOF, core::Milliseconds(28)},
                     {V4L2_BUF_FLAG_TSTAMP_SRC_SOE, core::Duration(0)}};
  for (const auto& one : cases) {
    V4l2StampClock clock;
    const core::MonoTime stamped = kBegin - core::Milliseconds(3);
    const auto stamp = Take(clock, stamped.ns(), kMonotonic | one.source, kBegin, rule);
    EXPECT_EQ(stamp.exposure_start, stamped - one.back);
    EXPECT_FALSE(stamp.foreign);
  }
}

/// Frames every 100 ms, stamped by a clock with this offset, delivered 5 to 25 ms late; how far the
/// results lie off the truth at most, once `settled` frames have been seen.
core::Duration WorstOf(std::uint32_t flags, std::uint64_t offset, int frames, double rate = 1.0) {
  V4l2StampClock clock;
  std::mt19937 dice(7);
  std::uniform_int_distribution<int> late_ms(5, 25);
  core::Duration worst{};
  for (int i = 0; i < frames; ++i) {
    const core::Duration since = i * core::Milliseconds(100);
    const core::MonoTime truth = kBegin + since;
    const auto counted = static_cast<std::uint64_t>(rate * static_cast<double>(since.count()));
    const auto stamp_ns = static_cast<std::int64_t>((offset + counted) / 1000 * 1000);
    const core::MonoTime arrival = truth + core::Milliseconds(late_ms(dice));
    const auto stamp = Take(clock, stamp_ns, flags | V4L2_BUF_FLAG_TSTAMP_SRC_SOE, arrival);
    EXPECT_TRUE(stamp.foreign);
    EXPECT_LE(stamp.exposure_start, arrival);
    if (i < 20) continue;
    // The least delay, 5 ms, cannot be told from the clock's offset.
    const core::Duration off = stamp.exposure_start - truth - core::Milliseconds(5);
    worst = std::max(worst, std::chrono::abs(off));
  }
  EXPECT_EQ(clock.stats().jumps, 0U);
  return worst;
}

TEST(V4l2Stamps, ForeignClocksKeepTheFramesSpacing) {
  const std::uint64_t wall = 1'795'000'000'000'000'000U;
  for (const std::uint32_t kind : {std::uint32_t{V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN},
                                   std::uint32_t{V4L2_BUF_FLAG_TIMESTAMP_COPY}, kMonotonic}) {
    EXPECT_LE(WorstOf(kind, wall, 200), core::Milliseconds(2)) << kind;
    EXPECT_LE(WorstOf(kind, 0, 200), core::Milliseconds(2)) << kind;
  }
}

TEST(V4l2Stamps, CountThatWrapsGoesOn) {
  const auto end = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  EXPECT_LE(WorstOf(kMonotonic, end - 10'000'000'000U, 200), core::Milliseconds(2));
  EXPECT_LE(WorstOf(kMonotonic, std::numeric_limits<std::uint64_t>::max() - 10'000'000'000U, 200),
            core::Milliseconds(2));
}

TEST(V4l2Stamps, CounterOfAnotherRateIsFollowed) {
  // 200 ppm over 200 s: 40 ms, were the first offset kept for good.
  EXPECT_LE(WorstOf(V4L2_BUF_FLAG_TIMESTAMP_COPY, 1000, 2000, 1.0002), core::Milliseconds(6));
  EXPECT_LE(WorstOf(V4L2_BUF_FLAG_TIMESTAMP_COPY, 1000, 2000, 0.9998), core::Milliseconds(6));
}

TEST(V4l2Stamps, JumpOfAForeignClockIsNoticed) {
  V4l2StampClock clock;
  const std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_COPY | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  std::int64_t stamp_ns = 1'000'000'000;
  core::MonoTime arrival = kBegin;
  for (int i = 0; i < 10; ++i) {
    if (i == 5) stamp_ns += 3'600'000'000'000;  // somebody set the wall clock
    stamp_ns += 100'000'000;
    arrival += core::Milliseconds(100);
    EXPECT_EQ(Take(clock, stamp_ns, flags, arrival).exposure_start, arrival) << i;
  }
  EXPECT_EQ(clock.stats().jumps, 1U);
}

TEST(V4l2Stamps, NonsenseNeitherCrashesNorLeavesThePast) {
  V4l2StampClock clock;
  std::mt19937_64 dice(3);
  core::MonoTime arrival = kBegin;
  const auto most = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i < 10000; ++i) {
    arrival += core::Milliseconds(33);
    const auto seconds = static_cast<std::int64_t>(dice());
    const auto micros = static_cast<std::int64_t>(dice());
    const auto stamp = clock.Take(i % 5 == 0 ? most : seconds, i % 7 == 0 ? -most : micros,
                                  static_cast<std::uint32_t>(dice()), arrival, {});
    EXPECT_LE(stamp.exposure_start, arrival + V4l2StampClock::kMaxAhead);
    EXPECT_GE(stamp.exposure_start, arrival - V4l2StampClock::kMaxDelay);
  }
}

}  // namespace
}  // namespace kawara::drivers
