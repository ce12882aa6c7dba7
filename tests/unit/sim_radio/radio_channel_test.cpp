#include "sim/radio/radio_channel.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace kawara::sim {
namespace {

constexpr std::size_t kPayload = 1000;
constexpr std::size_t kHeaders = RadioChannel::kUdpHeaderBytes + RadioChannel::kIpHeaderBytes;
core::MonoTime At(double s) {
  return core::MonoTime::FromNs(1'000'000'000) + core::DurationFromSeconds(s);
}

/// Arrival of each of `n` datagrams offered `spacing_s` apart.
std::vector<std::optional<core::MonoTime>> Send(RadioChannel& channel, int n, double spacing_s,
                                                const RadioFaults& faults = {}) {
  std::vector<std::optional<core::MonoTime>> arrivals;
  for (int i = 0; i < n; ++i)
    arrivals.push_back(channel.Offer(At(i * spacing_s), kPayload, faults));
  return arrivals;
}

TEST(RadioChannel, APerfectWireDeliversAtOnce) {
  RadioChannel channel({}, 1);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(channel.Offer(At(i), kPayload, {}), At(i));
  EXPECT_EQ(channel.counters().delivered_bytes, 100 * kPayload);
}

TEST(RadioChannel, RateSpacesDatagramsByTheirBitsWithHeaders) {
  RadioChannel channel(
      {.rate_bps = 8000.0 * (kPayload + kHeaders), .delay_s = 0.5, .queue_bytes = 1 << 20},
      1);  // 1 ms a datagram
  const auto arrivals = Send(channel, 50, 0.0);
  for (int i = 0; i < 50; ++i) {
    ASSERT_TRUE(arrivals[static_cast<std::size_t>(i)]);
    EXPECT_NEAR(core::ToSeconds(*arrivals[static_cast<std::size_t>(i)] - At(0)),
                0.5 + 1e-3 * (i + 1), 1e-6);
  }
}

TEST(RadioChannel, AFullQueueDropsTheNewestAndRecovers) {
  RadioChannel channel(
      {.rate_bps = 8000.0 * (kPayload + kHeaders), .queue_bytes = 10 * (kPayload + kHeaders)}, 1);
  Send(channel, 100, 0.0);
  const std::uint64_t accepted = channel.counters().delivered;
  EXPECT_EQ(accepted, 10U);
  EXPECT_EQ(channel.counters().dropped, 90U);
  EXPECT_TRUE(channel.Offer(At(10), kPayload, {}));
}

TEST(RadioChannel, LossHasItsShare) {
  RadioChannel channel({.loss = 0.2}, 7);
  Send(channel, 20000, 1e-3);
  // Standard deviation of the share: 0.003.
  EXPECT_NEAR(static_cast<double>(channel.counters().lost) / 20000.0, 0.2, 0.012);
}

TEST(RadioChannel, ALongDatagramIsManyPacketsAndNeedsThemAll) {
  constexpr std::size_t kLong = 65000;  // 44 packets of 1480 bytes
  RadioChannel perfect({.rate_bps = 8e6}, 1), lossy({.loss = 0.01}, 7);
  const auto arrival = perfect.Offer(At(0), kLong, {});
  ASSERT_TRUE(arrival);
  EXPECT_EQ(perfect.counters().packets, 44U);
  EXPECT_NEAR(core::ToSeconds(*arrival - At(0)), (kLong + 8 + 44 * 20) * 1e-6, 1e-8);
  for (int i = 0; i < 5000; ++i) lossy.Offer(At(i), kLong, {});
  // 1 - 0.99^44, standard deviation of the share 0.007.
  EXPECT_NEAR(static_cast<double>(lossy.counters().lost) / 5000.0, 0.357, 0.028);
}

TEST(RadioChannel, BurstsHaveTheirShareAndLength) {
  RadioChannel channel({.burst_loss = 0.2, .burst_length = 10.0}, 7);
  const auto arrivals = Send(channel, 100000, 1e-3);
  int bursts = 0, lost = 0;
  for (std::size_t i = 0; i < arrivals.size(); ++i) {
    lost += !arrivals[i];
    bursts += !arrivals[i] && (i == 0 || arrivals[i - 1]);
  }
  EXPECT_EQ(channel.counters().lost_in_bursts, static_cast<std::uint64_t>(lost));
  EXPECT_NEAR(lost / 1e5, 0.2, 0.025);  // some 2000 bursts
  EXPECT_NEAR(static_cast<double>(lost) / bursts, 10.0, 1.0);
}

TEST(RadioChannel, JitterKeepsTheOrder) {
  RadioChannel channel({.delay_s = 0.01, .jitter_s = 0.05}, 3);
  core::MonoTime last;
  bool delayed = false;
  for (int i = 0; i < 1000; ++i) {
    const auto arrival = channel.Offer(At(i * 0.01), kPayload, {});
    ASSERT_TRUE(arrival);
    EXPECT_GE(*arrival, last);
    EXPECT_GE(*arrival, At(i * 0.01 + 0.01));
    delayed = delayed || *arrival > At(i * 0.01 + 0.05);
    last = *arrival;
  }
  EXPECT_TRUE(delayed);
}

TEST(RadioChannel, FaultsMakeItWorseNeverBetter) {
  const RadioOptions good{.rate_bps = 8e6, .delay_s = 0.01};
  RadioChannel down(good, 1), slow(good, 1), late(good, 1), lossy(good, 1), fading(good, 1);
  EXPECT_FALSE(down.Offer(At(0), kPayload, {.down = true}));
  EXPECT_TRUE(down.Offer(At(1), kPayload, {}));
  EXPECT_EQ(down.counters().lost_while_down, 1U);
  EXPECT_GT(*slow.Offer(At(0), kPayload, {.rate_bps = 8e3}), At(1));
  EXPECT_LT(*slow.Offer(At(10), kPayload, {.rate_bps = 8e9}), At(10.02));
  EXPECT_EQ(*late.Offer(At(0), kPayload, {.delay_s = 2.0}) - *slow.Offer(At(20), kPayload, {}),
            At(2) - At(20));
  EXPECT_FALSE(lossy.Offer(At(0), kPayload, {.loss = 1.0}));
  Send(fading, 5000, 1e-3, {.burst_loss = 0.5});
  EXPECT_NEAR(static_cast<double>(fading.counters().lost_in_bursts) / 5000.0, 0.5, 0.2);
}

TEST(RadioChannel, WhatIsLostDependsOnTheSeedAndNotOnTiming) {
  const RadioOptions options{.jitter_s = 0.01, .loss = 0.3, .burst_loss = 0.2};
  RadioChannel fast(options, 5), slow(options, 5), other(options, 6);
  const auto a = Send(fast, 500, 1e-4), b = Send(slow, 500, 1.0), c = Send(other, 500, 1e-4);
  int same = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].has_value(), b[i].has_value()) << i;
    same += a[i].has_value() == c[i].has_value();
  }
  EXPECT_LT(same, 500);
}

}  // namespace
}  // namespace kawara::sim
