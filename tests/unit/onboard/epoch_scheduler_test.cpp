#include "onboard/epoch_scheduler.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace kawara::onboard {
namespace {

constexpr std::int64_t kMs = 1'000'000;

/// A receiver at 4 Hz whose epochs lie at x.249, x.499, ...; GPS time = mono + kOffset, fixes
/// arrive 60 ms late.
class EpochSchedulerTest : public testing::Test {
 protected:
  static constexpr std::int64_t kEpochPhase = 249 * kMs;
  static constexpr std::int64_t kGpsStart = 1'436'000'000'000'000'000 + kEpochPhase;
  static constexpr std::int64_t kMonoStart = 5'000'000'000'000;

  static core::MonoTime Mono(std::int64_t ms) {
    return core::MonoTime::FromNs(kMonoStart + ms * kMs);
  }
  static core::GpsTime Gps(std::int64_t ms) { return core::GpsTime::FromNs(kGpsStart + ms * kMs); }

  static estimation::GpsTimelineConfig Timeline() {
    estimation::GpsTimelineConfig config;
    config.envelope.min_latency_s = 0.06;
    return config;
  }

  /// Runs from `from` to `to` [ms]; fixes come while `receiving`.
  void Run(EpochScheduler& scheduler, std::int64_t from, std::int64_t to, bool receiving = true,
           double speed_mps = 0.0) {
    for (std::int64_t t = from; t < to; ++t) {
      if (receiving && t >= 60 && (t - 60) % 250 == 0) {
        timeline_.AddEpoch(Gps(t - 60), Mono(t));
        const core::Geodetic place{
            0.7, 0.1 + speed_mps * 1e-3 * static_cast<double>(t - 60) / 4.88e6, 0};
        scheduler.OnFix(Gps(t - 60), &place);
      }
      if (const auto due = scheduler.Due(Mono(t), timeline_)) {
        fired_.push_back(*due);
        fired_at_.push_back(t);
      }
    }
  }

  estimation::GpsTimeline timeline_{Timeline()};
  std::vector<PlannedExposure> fired_;
  std::vector<std::int64_t> fired_at_;
};

TEST_F(EpochSchedulerTest, FiresAtEveryFourthEpochWithinAMillisecondOfIt) {
  EpochScheduler scheduler({.every_epochs = 4});
  Run(scheduler, 0, 12'000);
  ASSERT_GE(fired_.size(), 9U);
  for (std::size_t i = 0; i < fired_.size(); ++i) {
    EXPECT_EQ((fired_[i].epoch.ns() - kGpsStart) % (250 * kMs), 0)
        << "on one of the receiver's epochs";
    EXPECT_NEAR(static_cast<double>(fired_at_[i]),
                static_cast<double>((fired_[i].epoch.ns() - kGpsStart) / kMs), 2.0);
    if (i == 0) continue;
    EXPECT_EQ((fired_[i].epoch - fired_[i - 1].epoch).count(), 1000 * kMs);
  }
}

TEST_F(EpochSchedulerTest, GoesOnWhileTheReceiverIsSilent) {
  EpochScheduler scheduler({.every_epochs = 4});
  Run(scheduler, 0, 10'000);
  const std::size_t before = fired_.size();
  Run(scheduler, 10'000, 20'000, /*receiving=*/false);
  EXPECT_EQ(fired_.size(), before + 10);
}

TEST_F(EpochSchedulerTest, DistanceRuleFollowsTheWayGone) {
  EpochScheduler scheduler({.every_epochs = 0, .every_m = 5.0});
  Run(scheduler, 0, 20'000, true, /*speed_mps=*/2.0);
  // 40 m at 2 m/s: every third second or so (5 m, then the next epoch).
  EXPECT_GE(fired_.size(), 6U);
  EXPECT_LE(fired_.size(), 8U);
  for (const auto& exposure : fired_) EXPECT_EQ(exposure.reason, PictureReason::kDistance);
}

TEST_F(EpochSchedulerTest, StandingStillTakesNoDistancePictures) {
  EpochScheduler scheduler({.every_epochs = 0, .every_m = 5.0});
  Run(scheduler, 0, 20'000, true, 0.0);
  EXPECT_TRUE(fired_.empty());
}

TEST_F(EpochSchedulerTest, CommandTakesOnePictureAtTheNextEpoch) {
  EpochScheduler scheduler({.every_epochs = 0});
  Run(scheduler, 0, 5'000);
  scheduler.RequestPicture();
  Run(scheduler, 5'000, 8'000);
  ASSERT_EQ(fired_.size(), 1U);
  EXPECT_EQ(fired_[0].reason, PictureReason::kCommand);
  EXPECT_LE(fired_at_[0], 5'600);
}

TEST_F(EpochSchedulerTest, FreeRunsWithoutAnyGpsTime) {
  EpochScheduler scheduler({.every_epochs = 4, .free_run_period_s = 1.0, .free_run_after_s = 5.0});
  Run(scheduler, 0, 15'000, /*receiving=*/false);
  EXPECT_NEAR(static_cast<double>(fired_.size()), 10.0, 1.0);
  for (const auto& exposure : fired_) {
    EXPECT_EQ(exposure.reason, PictureReason::kFreeRunning);
    EXPECT_FALSE(exposure.epoch.IsSet());
  }
}

TEST_F(EpochSchedulerTest, AStalledLoopSkipsInsteadOfFiringLate) {
  EpochScheduler scheduler({.every_epochs = 4});
  Run(scheduler, 0, 6'000);
  const std::size_t before = fired_.size();
  Run(scheduler, 8'500, 10'000);  // nobody called for 2.5 s
  EXPECT_GE(scheduler.skipped(), 1);
  for (std::size_t i = before; i < fired_.size(); ++i) {
    EXPECT_NEAR(static_cast<double>(fired_at_[i]),
                static_cast<double>((fired_[i].epoch.ns() - kGpsStart) / kMs), 2.0);
  }
}

}  // namespace
}  // namespace kawara::onboard
