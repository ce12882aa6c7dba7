#include "drivers/counter_clock.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace kawara::drivers {
namespace {

using core::MonoTime;

/// A sensor with its own crystal and a line with delays; knows the truth.
class Sensor {
 public:
  explicit Sensor(std::uint32_t seed, double skew = 0.0, double rate_hz = 60.0)
      : random_(seed), tick_ns_(790.0 * (1.0 + skew)), period_s_(1.0 / rate_hz) {}

  struct Packet {
    std::uint16_t counter;
    double true_s;
    MonoTime arrival;
  };
  /// Advances by `periods` and returns the packet sampled then; it arrives after the least delay (1
  /// ms), a usual jitter and `extra_s`, but never before an earlier one.
  Packet Next(double extra_s = 0.0, int periods = 1) {
    std::exponential_distribution<double> jitter(1.0 / 0.0007);
    std::normal_distribution<double> wobble(0.0, 50e-6);
    true_s_ += periods * period_s_;
    const double sampled_s = true_s_ + wobble(random_);
    const auto ticks = static_cast<std::int64_t>(sampled_s * 1e9 / tick_ns_);
    arrival_s_ = std::max(arrival_s_ + 1e-6, sampled_s + kLeastDelayS + jitter(random_) + extra_s);
    return {static_cast<std::uint16_t>(40'000 - ticks), sampled_s,
            MonoTime::FromNs(static_cast<std::int64_t>(arrival_s_ * 1e9))};
  }
  std::mt19937& random() { return random_; }
  static constexpr double kLeastDelayS = 0.001;

 private:
  std::mt19937 random_;
  double tick_ns_;
  double period_s_;
  double true_s_ = 100.0;
  double arrival_s_ = 0.0;
};

/// Stamp minus truth and the least delay, which no clock can know [s].
double Error(MonoTime stamp, const Sensor::Packet& p) {
  return static_cast<double>(stamp.ns()) * 1e-9 - p.true_s - Sensor::kLeastDelayS;
}

TEST(CounterClock, StampsAreNeverAfterArrivalAndAlwaysRise) {
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    Sensor sensor(seed);
    CounterClock clock;
    MonoTime last;
    for (int i = 0; i < 2000; ++i) {
      const auto p = sensor.Next();
      const MonoTime stamp = clock.Update(p.counter, p.arrival, false);
      EXPECT_LE(stamp, p.arrival);
      EXPECT_GT(stamp, last);
      last = stamp;
    }
    EXPECT_EQ(clock.stats().restarts, 1U) << seed;
  }
}

TEST(CounterClock, JitterIsTakenOut) {
  for (std::uint32_t seed = 0; seed < 10; ++seed) {
    Sensor sensor(seed);
    CounterClock clock;
    double sum2 = 0.0;
    int n = 0;
    for (int i = 0; i < 6000; ++i) {
      const auto p = sensor.Next();
      const double e = Error(clock.Update(p.counter, p.arrival, false), p);
      if (i < 1200) continue;
      sum2 += e * e;
      ++n;
    }
    EXPECT_LT(std::sqrt(sum2 / n), 100e-6) << "arrival jitter is 700 us";
  }
}

class CounterClockSkew : public ::testing::TestWithParam<double> {};
TEST_P(CounterClockSkew, IsLearnt) {
  Sensor sensor(7, GetParam());
  CounterClock clock;
  double worst = 0.0;
  for (int i = 0; i < 9000; ++i) {
    const auto p = sensor.Next();
    const double e = Error(clock.Update(p.counter, p.arrival, false), p);
    if (i > 600) worst = std::max(worst, std::abs(e));
  }
  EXPECT_NEAR(clock.skew_ppm(), GetParam() * 1e6, 15.0);
  EXPECT_LT(worst, 2e-3);
  EXPECT_EQ(clock.stats().restarts, 1U);
}
// 0.79 us is two digits: the true tick may be 0.6 % off.
INSTANTIATE_TEST_SUITE_P(Skews, CounterClockSkew,
                         ::testing::Values(0.0, 30e-6, -80e-6, 0.006, -0.006));

TEST(CounterClock, GapsWithLostPacketsAreCountedInWholeWraps) {
  for (std::uint32_t seed = 0; seed < 50; ++seed) {
    Sensor sensor(seed);
    CounterClock clock;
    int bad = 0;
    for (int i = 0; i < 3000; ++i) {
      const bool lost = i > 200 && sensor.random()() % 20 == 0;
      const auto p = sensor.Next(0.0, lost ? 2 + static_cast<int>(sensor.random()() % 50) : 1);
      const double e = Error(clock.Update(p.counter, p.arrival, lost), p);
      if (i > 300 && std::abs(e) > 3e-3) ++bad;
    }
    EXPECT_EQ(bad, 0) << seed;
  }
}

TEST(CounterClock, HeldUpPacketsKeepTheirPlaces) {
  // The reader sleeps; everything sampled meanwhile arrives at once afterwards, no byte is lost.
  for (const double sleep_s : {0.03, 0.06, 0.1, 0.2, 0.4, 0.8}) {
    Sensor sensor(11);
    CounterClock clock;
    int bad = 0;
    for (int i = 0; i < 3000; ++i) {
      // Packets of the sleep: each is late by what is left of it.
      const int in_sleep = i % 300;
      const double extra =
          i > 300 && in_sleep * (1.0 / 60) < sleep_s ? sleep_s - in_sleep * (1.0 / 60) : 0.0;
      const auto p = sensor.Next(extra);
      const double e = Error(clock.Update(p.counter, p.arrival, false), p);
      if (i > 290 && std::abs(e) > 3e-3) ++bad;
    }
    EXPECT_EQ(bad, 0) << sleep_s;
    EXPECT_EQ(clock.stats().restarts, 1U) << sleep_s;
  }
}

TEST(CounterClock, SilentGapWithoutLostBytesIsFoundWithinPackets) {
  // The unit pauses; what follows keeps its rhythm. At worst the pause looks like a held-up packet,
  // until eight in a row are equally late.
  for (int periods = 2; periods < 55; ++periods) {
    Sensor sensor(static_cast<std::uint32_t>(periods));
    CounterClock clock;
    int bad = 0;
    for (int i = 0; i < 1200; ++i) {
      const auto p = sensor.Next(0.0, i == 600 ? periods : 1);
      const double e = Error(clock.Update(p.counter, p.arrival, false), p);
      if (i > 300 && std::abs(e) > 6e-3) ++bad;
    }
    EXPECT_LE(bad, 8) << periods;
  }
}

TEST(CounterClock, SlowPollingIsUnwrappedByTheHostClock) {
  for (const double rate_hz : {3.0, 5.0, 10.0, 19.3, 25.0}) {
    Sensor sensor(3, 40e-6, rate_hz);
    CounterClock clock;
    int bad = 0;
    for (int i = 0; i < 500; ++i) {
      const auto p = sensor.Next();
      const double e = Error(clock.Update(p.counter, p.arrival, false), p);
      if (i > 50 && std::abs(e) > 3e-3) ++bad;
    }
    EXPECT_EQ(bad, 0) << rate_hz;
  }
}

TEST(CounterClock, LongSilenceStartsAnewAndKeepsTheTick) {
  Sensor sensor(5, 0.004);
  CounterClock clock;
  for (int i = 0; i < 3000; ++i) {
    const auto p = sensor.Next();
    clock.Update(p.counter, p.arrival, false);
  }
  const double learnt = clock.skew_ppm();
  auto p = sensor.Next(0.0, 300);
  // Restarted unit: the counter has nothing to do with what it was.
  const MonoTime stamp =
      clock.Update(static_cast<std::uint16_t>(p.counter + 12'345), p.arrival, false);
  EXPECT_EQ(stamp, p.arrival);
  EXPECT_EQ(clock.skew_ppm(), learnt);
  EXPECT_EQ(clock.stats().restarts, 2U);
}

TEST(CounterClock, EverythingAtOnceStaysMonotoneAndRecovers) {
  for (std::uint32_t seed = 0; seed < 30; ++seed) {
    Sensor sensor(seed, 0.001);
    CounterClock clock;
    MonoTime last;
    int bad = 0, settled = 0;
    double hold_s = 0.0;
    int calm = 0;
    for (int i = 0; i < 6000; ++i) {
      auto& random = sensor.random();
      if (hold_s <= 0.0 && random() % 300 == 0)
        hold_s = 0.001 * static_cast<double>(random() % 400);
      const bool lost = random() % 200 == 0;
      const bool pause = random() % 500 == 0;
      const int periods = lost || pause ? 2 + static_cast<int>(random() % 40) : 1;
      calm = hold_s > 0.0 || lost || pause ? 0 : calm + 1;
      const auto p = sensor.Next(std::max(hold_s, 0.0), periods);
      hold_s -= periods / 60.0;
      const MonoTime stamp = clock.Update(p.counter, p.arrival, lost);
      ASSERT_GT(stamp, last);
      last = stamp;
      if (i > 600 && calm > 30) {
        ++settled;
        if (std::abs(Error(stamp, p)) > 6e-3) ++bad;
      }
    }
    EXPECT_GT(settled, 2000);
    EXPECT_LE(bad, settled / 100) << seed;
  }
}

TEST(CounterClock, LatencyIsSubtracted) {
  CounterClockConfig config;
  config.latency = core::Milliseconds(4);
  CounterClock clock(config);
  EXPECT_EQ(clock.Update(100, MonoTime::FromNs(1'000'000'000), false),
            MonoTime::FromNs(996'000'000));
}

}  // namespace
}  // namespace kawara::drivers
