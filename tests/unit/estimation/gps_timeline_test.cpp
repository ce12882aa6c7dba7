#include "estimation/gps_timeline.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/support/counting_allocator.hpp"

namespace kawara::estimation {
namespace {

using core::Duration;
using core::DurationFromSeconds;
using core::GpsTime;
using core::Milliseconds;
using core::MonoTime;
using core::Seconds;

/// Truth: monotonic = start + (1 + drift) * (gps - start).
struct Bench {
  double drift_ppm = 25.0;
  GpsTime gps_start = GpsTime::FromNs(1'400'000'000'000'000'000);
  MonoTime mono_start = MonoTime::FromNs(77'000'000'123);
  double latency_s = 0.090;
  std::mt19937 random{4};

  GpsTime Gps(double t) const { return gps_start + DurationFromSeconds(t); }
  MonoTime Mono(double t) const {
    return mono_start + DurationFromSeconds(t * (1.0 + drift_ppm * 1e-6));
  }
  double ErrorOf(const GpsTimeline& line, double t) const {
    return core::ToSeconds(line.ToMono(Gps(t)).time - Mono(t));
  }
  double Jitter(double scale_s) {
    return std::exponential_distribution<double>(1.0 / scale_s)(random);
  }
  /// Ten epochs and one pulse for the second t.
  void Run(GpsTimeline& line, int second, bool pulse, double pulse_jitter_s = 5e-6) {
    if (pulse) line.AddPulse(Mono(second + Jitter(pulse_jitter_s)));
    for (int k = 0; k < 10; ++k) {
      const double t = second + 0.1 * k;
      line.AddEpoch(Gps(t), Mono(t + latency_s + Jitter(0.01)));
    }
  }
};

GpsTimelineConfig Config() {
  GpsTimelineConfig config;
  config.envelope.min_latency_s = 0.080;  // wrong by 10 ms, and says so
  config.envelope.min_latency_sigma_s = 0.010;
  return config;
}

TEST(GpsTimeline, NothingIsKnownAtFirst) {
  GpsTimeline line;
  EXPECT_FALSE(line.valid());
  EXPECT_EQ(line.Status(MonoTime::FromNs(1)).source, ClockSource::kNone);
  EXPECT_FALSE(line.NextEpoch(MonoTime::FromNs(1), Seconds(1)).has_value());
}

TEST(GpsTimeline, WithoutPulsesTheEnvelopeRules) {
  Bench bench;
  GpsTimeline line(Config());
  for (int s = 0; s < 60; ++s) bench.Run(line, s, false);
  EXPECT_EQ(line.Status(bench.Mono(60)).source, ClockSource::kEnvelope);
  EXPECT_NEAR(bench.ErrorOf(line, 59.9), 0.010, 0.002);  // the latency nobody knew
  EXPECT_LT(std::abs(bench.ErrorOf(line, 59.9)), 3.0 * line.ToMono(bench.Gps(59.9)).sigma_s);
}

TEST(GpsTimeline, PulsesGiveMicroseconds) {
  Bench bench;
  GpsTimeline line(Config());
  for (int s = 0; s < 120; ++s) bench.Run(line, s, true);
  const ClockStatus status = line.Status(bench.Mono(119.5));
  EXPECT_EQ(status.source, ClockSource::kPps);
  EXPECT_LT(std::abs(bench.ErrorOf(line, 119.5)), 20e-6);
  EXPECT_LT(std::abs(bench.ErrorOf(line, 119.5)), 4.0 * status.sigma_s);
  EXPECT_LT(status.sigma_s, 30e-6);
  EXPECT_NEAR(status.skew_ppm, -25.0, 1.0);
}

TEST(GpsTimeline, ConversionsAreInverse) {
  Bench bench;
  for (const bool pulses : {false, true}) {
    GpsTimeline line(Config());
    for (int s = 0; s < 60; ++s) bench.Run(line, s, pulses);
    for (const double t : {-5.0, 30.123456789, 59.999, 61.5, 300.0}) {
      const GpsTime back = line.ToGps(line.ToMono(bench.Gps(t)).time).time;
      EXPECT_NEAR(static_cast<double>((back - bench.Gps(t)).count()), 0.0, 2.0)
          << pulses << " " << t;
    }
  }
}

TEST(GpsTimeline, MissingPulsesAreBridgedWithGrowingSigma) {
  Bench bench;
  GpsTimeline line(Config());
  for (int s = 0; s < 60; ++s) bench.Run(line, s, true);
  double last = 0.0;
  for (int s = 60; s < 90; ++s) {
    bench.Run(line, s, false);
    const ClockStatus status = line.Status(bench.Mono(s + 0.95));
    EXPECT_GE(status.sigma_s, last);
    last = status.sigma_s;
    EXPECT_LT(std::abs(bench.ErrorOf(line, s)), 4.0 * status.sigma_s);
    EXPECT_EQ(status.source, s < 62 ? ClockSource::kPps : ClockSource::kHoldover) << s;
  }
  bench.Run(line, 90, true);
  EXPECT_EQ(line.Status(bench.Mono(90.5)).source, ClockSource::kPps);
}

TEST(GpsTimeline, EveryThirdPulseMissing) {
  Bench bench;
  GpsTimeline line(Config());
  for (int s = 0; s < 90; ++s) bench.Run(line, s, s % 3 != 0);
  EXPECT_LT(std::abs(bench.ErrorOf(line, 89.0)), 30e-6);
  EXPECT_EQ(line.Status(bench.Mono(90)).outliers, 0);
}

TEST(GpsTimeline, StrayAndDoubledPulsesAreRefused) {
  Bench bench;
  GpsTimeline line(Config());
  for (int s = 0; s < 60; ++s) bench.Run(line, s, true);
  for (int s = 60; s < 90; ++s) {
    bench.Run(line, s, true);
    line.AddPulse(bench.Mono(s + 0.0002));  // bounce
    if (s % 5 == 0) line.AddPulse(bench.Mono(s + 0.37));
  }
  EXPECT_LT(std::abs(bench.ErrorOf(line, 89.0)), 30e-6);
  EXPECT_EQ(line.pps().doubles(), 30);
  EXPECT_EQ(line.Status(bench.Mono(90)).outliers, 36);
  EXPECT_EQ(line.Status(bench.Mono(90)).steps, 0);
}

TEST(GpsTimeline, JitteryPulsesAreUsedForWhatTheyAreWorth) {
  Bench bench;
  GpsTimeline line(Config());
  for (int s = 0; s < 300; ++s) bench.Run(line, s, true, 1e-3);  // USB
  const ClockStatus status = line.Status(bench.Mono(299.5));
  EXPECT_EQ(status.source, ClockSource::kPps);
  // The mean of one-sided jitter is a bias nobody can see from the pulses alone.
  EXPECT_LT(std::abs(bench.ErrorOf(line, 299.5)), 2e-3);
}

TEST(GpsTimeline, PulsesThatMovedAreFollowed) {
  Bench bench;
  GpsTimeline line(Config());
  for (int s = 0; s < 60; ++s) bench.Run(line, s, true);
  for (int s = 60; s < 120; ++s) {
    bench.Run(line, s, false);
    line.AddPulse(bench.Mono(s + 0.005));
  }
  EXPECT_NEAR(bench.ErrorOf(line, 119.0), 0.005, 50e-6);
  EXPECT_EQ(line.Status(bench.Mono(120)).steps, 1);
}

/// Whatever the latency of the messages (also well above a second, also on a slow line that falls
/// behind): a pulse carries the right second or none, as long as the receiver's least latency is
/// below the configured bound.
TEST(GpsTimeline, NeverTheWrongSecond) {
  for (const double extra_s : {0.0, 0.3, 0.55, 0.9, 1.3, 2.7}) {
    Bench bench;
    GpsTimeline line(Config());
    int labelled = 0;
    for (int s = 0; s < 120; ++s) {
      line.AddPulse(bench.Mono(s + bench.Jitter(5e-6)));
      // Long bursts: two seconds in three are late by `extra_s`.
      const double late = s % 3 == 0 ? 0.0 : extra_s;
      for (int k = 0; k < 10; ++k) {
        const double t = s + 0.1 * k;
        line.AddEpoch(bench.Gps(t), bench.Mono(t + 0.09 + late + bench.Jitter(0.01)));
      }
      if (line.pps().locked()) {
        ++labelled;
        ASSERT_LT(std::abs(core::ToSeconds(line.pps().ToMono(bench.Gps(s)).time - bench.Mono(s))),
                  0.01)
            << extra_s << " at " << s;
      }
    }
    EXPECT_GT(labelled, 60) << extra_s;
  }
}

TEST(GpsTimeline, NoLabelWhenTwoSecondsArePossible) {
  Bench bench;
  bench.latency_s = 0.1;
  GpsTimelineConfig config = Config();
  config.max_min_latency_s =
      1.2;  // nobody knows better: this epoch's second and the next are possible
  GpsTimeline line(config);
  for (int s = 0; s < 60; ++s) bench.Run(line, s, true);
  EXPECT_FALSE(line.pps().locked());
  EXPECT_EQ(line.Status(bench.Mono(60)).source, ClockSource::kEnvelope);
}

TEST(GpsTimeline, PulseLabelsFromTheReceiverAreEnough) {
  Bench bench;
  GpsTimeline line(Config());
  for (int s = 0; s < 20; ++s) {
    line.AddPulse(bench.Mono(s));
    line.AddPulseLabel(bench.Gps(s), bench.Mono(s + 0.06));
  }
  ASSERT_TRUE(line.pps().locked());
  EXPECT_LT(std::abs(bench.ErrorOf(line, 19.0)), 20e-6);
}

TEST(GpsTimeline, LateLabelsAreNotUsed) {
  Bench bench;
  GpsTimeline line(Config());
  for (int s = 0; s < 20; ++s) {
    line.AddPulse(bench.Mono(s));
    line.AddPulseLabel(bench.Gps(s), bench.Mono(s + 0.7));
  }
  EXPECT_FALSE(line.pps().locked());
}

TEST(GpsTimeline, ContradictingLabelsUnlock) {
  Bench bench;
  GpsTimeline line(Config());
  for (int s = 0; s < 30; ++s) {
    line.AddPulse(bench.Mono(s));
    // A receiver that corrects its own second after a while.
    line.AddPulseLabel(bench.Gps(s + (s < 15 ? 1 : 0)), bench.Mono(s + 0.06));
  }
  ASSERT_TRUE(line.pps().locked());
  EXPECT_LT(std::abs(bench.ErrorOf(line, 29.0)), 20e-6);
  EXPECT_GE(line.pps().label_conflicts(), 5);
}

TEST(GpsTimeline, NextEpochIsOnTheGrid) {
  Bench bench;
  GpsTimeline line(Config());
  for (int s = 0; s < 60; ++s) bench.Run(line, s, true);
  for (const double now : {60.0, 60.05, 60.9999, 61.0}) {
    const auto next =
        line.NextEpoch(bench.Mono(now), Milliseconds(500), Milliseconds(100), Milliseconds(20));
    ASSERT_TRUE(next.has_value());
    EXPECT_EQ((next->gps - Milliseconds(100)).ns() % Milliseconds(500).count(), 0);
    EXPECT_GE(next->mono, bench.Mono(now) + Milliseconds(20));
    EXPECT_LT(next->mono, bench.Mono(now) + Milliseconds(521));
    const double true_s = core::ToSeconds(next->gps - bench.gps_start);
    EXPECT_LT(std::abs(core::ToSeconds(next->mono - bench.Mono(true_s))), 30e-6);
  }
}

TEST(GpsTimeline, NextEpochAlwaysAdvances) {
  Bench bench;
  GpsTimeline line(Config());
  for (int s = 0; s < 20; ++s) bench.Run(line, s, false);
  MonoTime now = bench.Mono(20);
  GpsTime last;
  for (int i = 0; i < 100; ++i) {
    const auto next = line.NextEpoch(now, Milliseconds(100));
    ASSERT_TRUE(next.has_value());
    ASSERT_GT(next->gps, last);
    last = next->gps;
    now = next->mono + core::Nanoseconds(10);
  }
}

TEST(GpsTimeline, SameInputSameOutputAndNoAllocation) {
  std::vector<std::int64_t> runs[2];
  runs[0].reserve(2000);
  runs[1].reserve(2000);
  for (auto& out : runs) {
    Bench bench;
    const std::uint64_t allocations = kawara::testing::AllocationsOfThisThread();
    GpsTimeline line(Config());
    for (int s = 0; s < 200; ++s) {
      bench.Run(line, s, s % 7 != 0, 1e-4);
      line.AddPulseLabel(bench.Gps(s), bench.Mono(s + 0.06));
      const ClockStatus status = line.Status(bench.Mono(s + 0.99));
      out.push_back(status.stream.ns());
      out.push_back(static_cast<std::int64_t>(status.sigma_s * 1e15));
    }
    EXPECT_EQ(kawara::testing::AllocationsOfThisThread(), allocations);
  }
  EXPECT_EQ(runs[0], runs[1]);
}

}  // namespace
}  // namespace kawara::estimation
