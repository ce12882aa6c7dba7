#include "estimation/envelope_clock.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/counting_allocator.hpp"

namespace kawara::estimation {
namespace {

using core::Duration;
using core::DurationFromSeconds;
using core::MonoTime;
using core::Seconds;

/// A stream whose truth is known: stream = start + (1 + skew) (mono - mono start).
struct World {
  double skew_ppm = 30.0;
  std::int64_t stream_start_ns = 1'400'000'000'000'000'000;  // GPS time of 2024
  std::int64_t mono_start_ns = 5'000'000'000'000;
  double jump_s = 0.0;  // stream clock steps add up here

  StreamTime Stream(double since_start_s) const {
    return StreamTime::FromNs(stream_start_ns) +
           DurationFromSeconds(since_start_s * (1.0 + skew_ppm * 1e-6) + jump_s);
  }
  MonoTime Mono(double since_start_s) const {
    return MonoTime::FromNs(mono_start_ns) + DurationFromSeconds(since_start_s);
  }
  /// Error of the clock's answer for a true instant [s]: mapped minus true.
  double ErrorOf(const EnvelopeClock& clock, double since_start_s) const {
    return core::ToSeconds(clock.ToMono(Stream(since_start_s)).time - Mono(since_start_s));
  }
};

EnvelopeConfig KnownLatency(double latency_s) {
  EnvelopeConfig config;
  config.min_latency_s = latency_s;
  config.min_latency_sigma_s = 0.0005;
  return config;
}

class Delay {
 public:
  explicit Delay(unsigned seed) : random_(seed) {}
  /// Minimum 80 ms, exponential 15 ms on top, now and then 200 ms.
  double operator()() {
    double delay = 0.080 + jitter_(random_);
    if (random_() % 20 == 0) delay += 0.2;
    return delay;
  }

 private:
  std::mt19937 random_;
  std::exponential_distribution<double> jitter_{1.0 / 0.015};
};

TEST(EnvelopeClock, NothingBeforeTheFirstSample) {
  EnvelopeClock clock;
  EXPECT_FALSE(clock.valid());
  EXPECT_EQ(clock.Status(MonoTime::FromNs(5)).source, ClockSource::kNone);
}

/// Named tolerance: with 80 ms + exp(15 ms) delays at 10 Hz the line must be within 1.5 ms of the
/// truth after a minute (the least of 600 exponential delays is 0.025 ms; the rest is skew), for
/// any skew the config expects.
class EnvelopeSkew : public ::testing::TestWithParam<double> {};
TEST_P(EnvelopeSkew, OffsetAndSkewAreFound) {
  World world;
  world.skew_ppm = GetParam();
  EnvelopeClock clock(KnownLatency(0.080));
  Delay delay(7);
  for (int i = 0; i < 3000; ++i) {
    const double t = 0.1 * i;
    clock.Add(world.Stream(t), world.Mono(t + delay()));
    if (t > 60.0) {
      ASSERT_LT(std::abs(world.ErrorOf(clock, t)), 1.5e-3) << t;
      ASSERT_LT(std::abs(world.ErrorOf(clock, t)), 4.0 * clock.ToMono(world.Stream(t)).sigma_s)
          << t;
    }
  }
  EXPECT_NEAR(clock.Status(world.Mono(300)).skew_ppm, GetParam(), 8.0);
  EXPECT_EQ(clock.Status(world.Mono(300)).steps, 0);
  EXPECT_EQ(clock.Status(world.Mono(300)).outliers, 0);
}
INSTANTIATE_TEST_SUITE_P(Ppm, EnvelopeSkew, ::testing::Values(-100.0, -30.0, 0.0, 30.0, 100.0));

TEST(EnvelopeClock, SigmaIsHonestOverManySeeds) {
  // Normalised errors over seeds and instants, start-up included: few may lie outside 3 sigma, and
  // sigma may not be so large as to be useless.
  int outside = 0, total = 0;
  double sigma_at_end = 0.0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    World world;
    EnvelopeClock clock(KnownLatency(0.080));
    Delay delay(seed);
    for (int i = 0; i < 900; ++i) {
      const double t = 0.1 * i;
      clock.Add(world.Stream(t), world.Mono(t + delay()));
      const auto mapped = clock.ToMono(world.Stream(t));
      ++total;
      outside += std::abs(world.ErrorOf(clock, t)) > 3.0 * mapped.sigma_s ? 1 : 0;
      sigma_at_end = mapped.sigma_s;
    }
  }
  EXPECT_LT(outside, total / 50);
  EXPECT_LT(sigma_at_end, 0.005);
}

TEST(EnvelopeClock, BothDirectionsAreInverse) {
  World world;
  EnvelopeClock clock(KnownLatency(0.080));
  Delay delay(3);
  for (int i = 0; i < 500; ++i) clock.Add(world.Stream(0.1 * i), world.Mono(0.1 * i + delay()));
  for (const double t : {-100.0, 0.0, 3.33333333, 49.9, 60.0, 1000.0}) {
    const MonoTime mono = clock.ToMono(world.Stream(t)).time;
    EXPECT_NEAR(static_cast<double>((clock.ToStream(mono).time - world.Stream(t)).count()), 0.0,
                2.0)
        << t;
  }
}

TEST(EnvelopeClock, LateBurstChangesNothing) {
  World world;
  EnvelopeClock clock(KnownLatency(0.080));
  Delay delay(5);
  double before = 0.0;
  for (int i = 0; i < 1200; ++i) {
    const double t = 0.1 * i;
    double arrival = t + delay();
    // The reader was stopped for 5 s: everything of that time arrives at once, in order.
    if (t >= 80.0 && t < 85.0) arrival = 85.0 + 1e-4 * (t - 80.0);
    clock.Add(world.Stream(t), world.Mono(arrival));
    if (i == 799) before = world.ErrorOf(clock, 79.9);
  }
  EXPECT_NEAR(world.ErrorOf(clock, 90.0), before, 1e-3);
  EXPECT_EQ(clock.Status(world.Mono(120)).steps, 0);
}

TEST(EnvelopeClock, MoreLatencyIsNotAStep) {
  World world;
  EnvelopeClock clock(KnownLatency(0.080));
  Delay delay(5);
  for (int i = 0; i < 1000; ++i) {
    const double t = 0.1 * i;
    clock.Add(world.Stream(t),
              world.Mono(t + delay() + (t > 70.0 ? 1.5 : 0.0)));  // another RTK mode
  }
  EXPECT_LT(std::abs(world.ErrorOf(clock, 99.9)), 5e-3);
  EXPECT_EQ(clock.Status(world.Mono(100)).steps, 0);
}

struct StepCase {
  const char* name;
  double jump_s;
  double rate_hz;
};
class EnvelopeStep : public ::testing::TestWithParam<StepCase> {};
TEST_P(EnvelopeStep, IsCountedOnceAndFollowed) {
  World world;
  EnvelopeClock clock(KnownLatency(0.080));
  Delay delay(9);
  const int n = static_cast<int>(120.0 * GetParam().rate_hz);
  for (int i = 0; i < n; ++i) {
    const double t = i / GetParam().rate_hz;
    if (i == n / 2) world.jump_s = GetParam().jump_s;
    clock.Add(world.Stream(t), world.Mono(t + delay()));
  }
  EXPECT_EQ(clock.Status(world.Mono(120)).steps, 1);
  EXPECT_LT(std::abs(world.ErrorOf(clock, 119.0)), 0.02);
}
INSTANTIATE_TEST_SUITE_P(Table, EnvelopeStep,
                         ::testing::Values(StepCase{"forward 1 s", 1.0, 10},
                                           StepCase{"back 1 s", -1.0, 10},
                                           StepCase{"forward 1 s at 1 Hz", 1.0, 1},
                                           StepCase{"back 2 s at 1 Hz", -2.0, 1},
                                           StepCase{"1024 weeks", 1024.0 * 604800.0, 10},
                                           StepCase{"1024 weeks back", -1024.0 * 604800.0, 10},
                                           StepCase{"counter reset", -1.4e9, 100}));

TEST(EnvelopeClock, OneWrongStampIsAnOutlier) {
  for (const double wrong_s : {-3600.0, -1.0, 1.0, 604800.0}) {
    World world;
    EnvelopeClock clock(KnownLatency(0.080));
    Delay delay(11);
    std::int64_t before = 0;
    for (int i = 0; i < 600; ++i) {
      const double t = 0.1 * i;
      world.jump_s = i == 300 ? wrong_s : 0.0;
      if (i == 300) before = clock.Status(world.Mono(t)).outliers;
      clock.Add(world.Stream(t), world.Mono(t + delay()));
    }
    EXPECT_EQ(clock.Status(world.Mono(60)).steps, 0) << wrong_s;
    EXPECT_EQ(clock.Status(world.Mono(60)).outliers, before + 1) << wrong_s;
    EXPECT_LT(std::abs(world.ErrorOf(clock, 59.9)), 2e-3) << wrong_s;
  }
}

TEST(EnvelopeClock, RepeatedStampsAreIgnored) {
  World world;
  EnvelopeClock clock;
  clock.Add(world.Stream(0), world.Mono(0.1));
  EXPECT_EQ(clock.Add(world.Stream(0), world.Mono(0.15)), EnvelopeClock::Result::kIgnored);
}

TEST(EnvelopeClock, HoldoverGrowsAndSaysSo) {
  World world;
  EnvelopeClock clock(KnownLatency(0.080));
  Delay delay(13);
  for (int i = 0; i < 1200; ++i) clock.Add(world.Stream(0.1 * i), world.Mono(0.1 * i + delay()));
  EXPECT_EQ(clock.Status(world.Mono(121)).source, ClockSource::kEnvelope);
  EXPECT_EQ(clock.Status(world.Mono(130)).source, ClockSource::kHoldover);
  double last = 0.0;
  for (const double t : {120.0, 180.0, 600.0, 3600.0}) {
    const double sigma = clock.ToMono(world.Stream(t)).sigma_s;
    EXPECT_GT(sigma, last);
    EXPECT_LT(std::abs(world.ErrorOf(clock, t)), 3.0 * sigma) << t;
    last = sigma;
  }
}

TEST(EnvelopeClock, AfterALongGapTheOldLineIsNotThrownAwayForOneLateSample) {
  World world;
  EnvelopeClock clock(KnownLatency(0.080));
  Delay delay(17);
  for (int i = 0; i < 1200; ++i) clock.Add(world.Stream(0.1 * i), world.Mono(0.1 * i + delay()));
  clock.Add(world.Stream(400.0), world.Mono(400.9));
  EXPECT_LT(std::abs(world.ErrorOf(clock, 400.0)), 0.01);
}

TEST(EnvelopeClock, ExtremeStampsDoNoHarm) {
  constexpr std::int64_t kMin = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
  EnvelopeClock clock;
  for (const std::int64_t s :
       {kMin, kMax, kMin / 2, kMax / 2, kMax / 5, -kMax / 5, std::int64_t{0}}) {
    for (const std::int64_t m : {kMin, kMax, kMax / 5, std::int64_t{0}, kMax / 5 + 1}) {
      for (int i = 0; i < 4; ++i)
        clock.Add(StreamTime::FromNs(s - (s == kMin ? 0 : i % 2)), MonoTime::FromNs(m));
      if (!clock.valid()) continue;
      EXPECT_TRUE(std::isfinite(clock.ToMono(StreamTime::FromNs(s)).sigma_s));
      EXPECT_TRUE(std::isfinite(clock.ToStream(MonoTime::FromNs(m)).sigma_s));
    }
  }
}

struct Arrival {
  double t = 0.0;
  double delay = 0.0;
};
std::vector<Arrival> RecordedArrivals() {
  std::ifstream file(KAWARA_SOURCE_DIR "/data/estimation/gnss_arrivals.csv");
  std::vector<Arrival> arrivals;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    Arrival a;
    char comma = 0;
    std::istringstream(line) >> a.t >> comma >> a.delay;
    a.delay *= 1e-3;
    arrivals.push_back(a);
  }
  return arrivals;
}

/// The receiver's whole run: delays of 85 to 351 ms, six outages of 10 to 60 s; a skew is put on
/// top.
TEST(EnvelopeClock, RecordedArrivalTimes) {
  const auto arrivals = RecordedArrivals();
  ASSERT_EQ(arrivals.size(), 10601u);
  World world;
  world.skew_ppm = -42.0;
  EnvelopeClock clock(KnownLatency(0.085));
  double sum2 = 0.0, worst = 0.0, worst_ratio = 0.0;
  int n = 0;
  for (const Arrival& a : arrivals) {
    clock.Add(world.Stream(a.t), world.Mono(a.t + a.delay));
    if (a.t < 30.0) continue;
    const double error = world.ErrorOf(clock, a.t);
    sum2 += error * error;
    worst = std::max(worst, std::abs(error));
    worst_ratio = std::max(worst_ratio, std::abs(error) / clock.ToMono(world.Stream(a.t)).sigma_s);
    ++n;
  }
  RecordProperty("rms_us", std::to_string(1e6 * std::sqrt(sum2 / n)));
  RecordProperty("worst_us", std::to_string(1e6 * worst));
  EXPECT_LT(std::sqrt(sum2 / n), 0.5e-3);
  EXPECT_LT(worst, 3e-3);
  EXPECT_LT(worst_ratio, 4.0);
  EXPECT_EQ(clock.Status(world.Mono(1235)).steps, 0);
}

TEST(EnvelopeClock, SameInputSameBytes) {
  const auto arrivals = RecordedArrivals();
  std::vector<std::int64_t> runs[2];
  for (auto& out : runs) {
    World world;
    EnvelopeClock clock;
    for (const Arrival& a : arrivals) {
      clock.Add(world.Stream(a.t), world.Mono(a.t + a.delay));
      const auto mapped = clock.ToMono(world.Stream(a.t));
      std::int64_t bits = 0;
      std::memcpy(&bits, &mapped.sigma_s, sizeof bits);
      out.push_back(mapped.time.ns());
      out.push_back(bits);
    }
  }
  EXPECT_EQ(runs[0], runs[1]);
}

TEST(EnvelopeClock, NeverAllocates) {
  World world;
  Delay delay(19);
  const std::uint64_t allocations = kawara::testing::AllocationsOfThisThread();
  EnvelopeClock clock;
  for (int i = 0; i < 2000; ++i) {
    if (i == 1500) world.jump_s = -30.0;
    clock.Add(world.Stream(0.1 * i), world.Mono(0.1 * i + delay()));
    clock.Status(world.Mono(0.1 * i));
  }
  EXPECT_EQ(kawara::testing::AllocationsOfThisThread(), allocations);
}

}  // namespace
}  // namespace kawara::estimation
