#include "onboard/pulse_chain.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace kawara::onboard {
namespace {

constexpr core::Duration kLatency = core::Milliseconds(50);

/// A receiver with a pulse, second by second, and what the chain says of it.
class PulsedTime : public ::testing::Test {
 protected:
  static estimation::GpsTimelineConfig Config() {
    estimation::GpsTimelineConfig config;
    config.envelope.min_latency_s = core::ToSeconds(kLatency);
    config.envelope.min_latency_sigma_s = 100e-6;
    return config;
  }
  static PpsSettings Settings(const char* device) {
    PpsSettings settings;
    settings.device = device;
    return settings;
  }
  void Seconds(int n, bool pulses) {
    for (int i = 0; i < n; ++i) {
      if (pulses) chain_.OnEdge(mono_, ++sequence_);
      for (int epoch = 0; epoch < 10; ++epoch) {
        timeline_.AddEpoch(gps_ + core::Milliseconds(100) * epoch,
                           mono_ + core::Milliseconds(100) * epoch + kLatency);
      }
      mono_ += core::Seconds(1);
      gps_ += core::Seconds(1);
      chain_.Tick(mono_);
      core::Event event;
      while (events_.TryPop(event)) said_.emplace_back(event.name);
    }
  }

  core::MonoTime mono_ = core::MonoTime::FromNs(1'000'000'000'000);
  core::GpsTime gps_ = core::GpsTime::FromNs(1'400'000'000'000'000'000);
  std::uint32_t sequence_ = 0;
  estimation::GpsTimeline timeline_{Config()};
  core::Events events_;
  PulseChain chain_{Settings("pps.sock"), timeline_, events_};
  std::vector<std::string> said_;
};

using Names = std::vector<std::string>;

TEST_F(PulsedTime, PulsesRuleOnceTheirSecondsAreCertain) {
  Seconds(60, true);
  EXPECT_EQ(said_, Names{"clock.pps"});
  const auto status = timeline_.Status(mono_);
  EXPECT_EQ(status.source, estimation::ClockSource::kPps);
  EXPECT_LT(status.sigma_s, 30e-6);
}

TEST_F(PulsedTime, LosingThemIsHoldOverAndThenArrivalsAndTheirReturnIsTold) {
  Seconds(60, true);
  Seconds(30, false);
  EXPECT_EQ(said_, (Names{"clock.pps", "clock.holdover"}));
  EXPECT_LT(timeline_.Status(mono_).sigma_s, 100e-6) << "still better than arrivals";
  Seconds(5000, false);
  EXPECT_EQ(said_, (Names{"clock.pps", "clock.holdover", "clock.no_pps"}));
  EXPECT_EQ(timeline_.Status(mono_).source, estimation::ClockSource::kEnvelope);
  Seconds(60, true);
  EXPECT_EQ(said_, (Names{"clock.pps", "clock.holdover", "clock.no_pps", "clock.pps"}));
}

TEST_F(PulsedTime, PulsesThatNeverComeAreComplainedAbout) {
  Seconds(35, false);
  EXPECT_EQ(said_, Names{"clock.no_pps"});
}

TEST_F(PulsedTime, SpuriousEdgesAreRefusedAndGapsCounted) {
  Seconds(30, true);
  for (int i = 0; i < 10; ++i) {
    Seconds(1, true);
    chain_.OnEdge(mono_ - core::Milliseconds(600), ++sequence_);
  }
  EXPECT_EQ(chain_.stats().refused, 10);
  EXPECT_EQ(timeline_.Status(mono_).source, estimation::ClockSource::kPps);
  EXPECT_NEAR(core::ToSeconds(timeline_.ToGps(mono_).time - gps_), 0.0, 50e-6);
  sequence_ += 3;
  Seconds(1, true);
  EXPECT_EQ(chain_.stats().missing, 3);
}

TEST_F(PulsedTime, WithoutAWireNothingIsSaid) {
  PulseChain none{Settings(""), timeline_, events_};
  Seconds(5, false);
  for (int i = 0; i < 100; ++i) none.Tick(mono_ + core::Seconds(i));
  core::Event event;
  EXPECT_FALSE(events_.TryPop(event));
}

TEST_F(PulsedTime, PulsesAtAWrongRateAreSaidToBe) {
  for (int second = 0; second < 70; ++second) {
    for (int epoch = 0; epoch < 10; ++epoch) {
      const core::Duration at = core::Milliseconds(100) * epoch;
      if (epoch % 4 == 2) chain_.OnEdge(mono_ + at, ++sequence_);
      timeline_.AddEpoch(gps_ + at, mono_ + at + kLatency);
    }
    mono_ += core::Seconds(1);
    gps_ += core::Seconds(1);
    chain_.Tick(mono_);
  }
  core::Event event;
  std::string all;
  while (events_.TryPop(event))
    all += std::string(event.name) + ": " + std::string(event.text.view());
  EXPECT_NE(all.find("clock.no_pps"), std::string::npos) << all;
  EXPECT_NE(all.find("not one a second"), std::string::npos) << all;
}

}  // namespace
}  // namespace kawara::onboard
