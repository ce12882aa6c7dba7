// What the navigator refuses, survives, and repeats exactly.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "estimation/filter_tape.hpp"
#include "tests/support/counting_allocator.hpp"
#include "tests/support/drive_player.hpp"

namespace kawara::estimation {
namespace {

using testing::ConfigOf;
using testing::DrivePlan;
using testing::DriveRecording;
using testing::DriveSensors;
using testing::Give;
using testing::Play;
using testing::PositionError;
using testing::Record;
using Kind = DriveRecording::Kind;

DriveSensors Sensors() {
  DriveSensors sensors;
  sensors.imu = *FindSensorProfile("ahrs400cc-100");
  return sensors;
}

const DriveRecording& Drive() {
  static const DriveRecording drive = Record({.duration_s = 80.0}, Sensors(), 21);
  return drive;
}

/// The drive with every position of a span moved by one vector, its stated accuracy as ever.
DriveRecording WithWrongFixes(double from_s, double to_s, const Eigen::Vector3d& ned_m) {
  DriveRecording drive = Drive();
  for (auto& fix : drive.fixes) {
    const double t_s = testing::DriveSeconds(fix.time);
    if (t_s >= from_s && t_s < to_s) fix.antenna = Displaced(fix.antenna, ned_m);
  }
  return drive;
}

TEST(NavigatorTrust, WrongFixIsRefusedCountedAndForgiven) {
  const DriveRecording drive = WithWrongFixes(50.0, 58.0, {0.8, -0.6, 0.0});
  Navigator navigator(ConfigOf(Sensors()));
  double during_m = 0.0, after_m = 0.0;
  bool said_so = false, nominal_after = false;
  Play(drive, navigator, [&](std::size_t i) {
    const double t_s = drive.truth[i].t_s;
    const double error_m = PositionError(navigator.Latest(), drive.truth[i]).norm();
    if (t_s > 50.0 && t_s < 58.0) {
      during_m = std::max(during_m, error_m);
      said_so = said_so || navigator.Latest().reason == NavReason::kGnssRefused;
    }
    if (t_s > 61.0 && t_s < 70.0) {
      after_m = std::max(after_m, error_m);
      nominal_after = navigator.Latest().state == NavState::kFixed;
    }
  });
  EXPECT_LT(during_m, 0.30);
  EXPECT_LT(after_m, 0.06);
  EXPECT_TRUE(said_so);
  EXPECT_TRUE(nominal_after);
  EXPECT_EQ(navigator.stats().wrong_fix_episodes, 1);
  EXPECT_EQ(navigator.stats().resets, 0);
  const auto& fixed = navigator.stats().source[static_cast<std::size_t>(NavSource::kFixed)];
  EXPECT_GE(fixed.rejected, 80);
  EXPECT_LE(fixed.rejected, 80 + 8);  // and probation of half a second
}

TEST(NavigatorTrust, FixesThatStayAreRightAfterAll) {
  const DriveRecording drive = WithWrongFixes(40.0, 1000.0, {2.0, 1.0, 0.5});
  Navigator navigator(ConfigOf(Sensors()));
  Play(drive, navigator);
  EXPECT_EQ(navigator.stats().resets, 1);
  const Eigen::Vector3d error = PositionError(navigator.Latest(), drive.truth.back());
  EXPECT_LT((error + Eigen::Vector3d(2.0, 1.0, 0.5)).norm(), 0.1);
}

/// 20 s without fixes and wheels the inertial unit is metres away: the first fixes are believed.
TEST(NavigatorTrust, FixAfterAnInertialOutageIsTaken) {
  DriveRecording drive = Drive();
  const auto in_outage = [](core::GpsTime t) {
    const double t_s = testing::DriveSeconds(t);
    return t_s > 45.0 && t_s < 65.0;
  };
  std::erase_if(drive.fixes, [&](const core::GnssFix& fix) { return in_outage(fix.time); });
  drive.wheels.clear();
  NavigationConfig config = ConfigOf(Sensors());
  config.constraint = ConstraintMode::kOff;
  Navigator navigator(config);
  NavState in_the_middle = NavState::kNone;
  double after_m = 1e9;
  Play(drive, navigator, [&](std::size_t i) {
    if (drive.truth[i].t_s < 55.0) in_the_middle = navigator.Latest().state;
    if (drive.truth[i].t_s < 68.0)
      after_m = PositionError(navigator.Latest(), drive.truth[i]).norm();
  });
  EXPECT_EQ(in_the_middle, NavState::kInertial);
  EXPECT_LT(after_m, 0.15);
  EXPECT_EQ(navigator.stats().outages, 1);
  EXPECT_NEAR(navigator.stats().longest_outage_s, 20.0, 0.2);
}

/// Fixes and wheels come late by anything up to 0.45 s, in any order.
TEST(NavigatorLateData, CatchesUpWithDataInOrder) {
  NavigationConfig config = ConfigOf(Sensors());
  config.time_offset_sd_s = 0.0;  // where a fix is placed depends on what was known when it came
  config.gnss.velocity_delay_sd_s = 1e-6;
  Navigator in_order(config), late(config);
  auto order = Drive().InOrder();
  for (const auto& arrival : order) Give(in_order, Drive(), arrival);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> delay(0.0, 0.45);
  for (auto& arrival : order) {
    // The last second in time, so that everything has arrived in the end.
    if (arrival.kind != Kind::kImu && arrival.t_s < 79.0) arrival.t_s += delay(random);
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.t_s < b.t_s; });
  for (const auto& arrival : order) Give(late, Drive(), arrival);
  EXPECT_GT(late.stats().late_fused, 1000);
  EXPECT_EQ(late.stats().too_late, 0);
  const NavSolution& a = in_order.Latest();
  const NavSolution& b = late.Latest();
  ASSERT_TRUE(a.valid() && b.valid());
  EXPECT_EQ(a.time, b.time);
  EXPECT_LT(Displacement(a.position, b.position).norm(), 0.001);
  const Eigen::Matrix3d turn =
      core::RotationNedFromBody(a.attitude).transpose() * core::RotationNedFromBody(b.attitude);
  EXPECT_LT(Eigen::AngleAxisd(turn).angle(), 0.002 * core::kRadFromDeg);
}

TEST(NavigatorLateData, RefusesAndCountsWhatIsTooLateOrRepeated) {
  Navigator navigator(ConfigOf(Sensors()));
  Play(Drive(), navigator);
  const auto& fixes = Drive().fixes;
  const NavSolution before = navigator.Latest();
  core::GnssFix old = fixes[fixes.size() - 20];  // two seconds
  old.has_velocity = false;
  navigator.AddFix(old);
  EXPECT_EQ(navigator.stats().too_late, 1);
  navigator.AddOdometry(Drive().wheels.back());
  EXPECT_EQ(navigator.stats().repeated, 1);
  EXPECT_EQ(Displacement(before.position, navigator.Latest().position).norm(), 0.0);
}

TEST(NavigatorAt, GivesTheTruthBetweenSamplesAndNothingOutside) {
  Navigator navigator(ConfigOf(Sensors()));
  EXPECT_FALSE(navigator.At(testing::DriveTime(1.0)));
  Play(Drive(), navigator);
  const core::GpsTime newest = navigator.Latest().time;
  const auto on = navigator.At(newest - core::Milliseconds(200));
  const auto between = navigator.At(newest - core::Milliseconds(193));
  ASSERT_TRUE(on && between);
  const Eigen::Vector3d way = Displacement(on->position, between->position);
  EXPECT_LT((way - 0.007 * on->velocity_ned_mps).norm(), 0.002);
  EXPECT_TRUE(navigator.At(newest + core::Milliseconds(50)));
  EXPECT_FALSE(navigator.At(newest + core::Milliseconds(150)));
  EXPECT_FALSE(navigator.At(newest - core::Milliseconds(60'000)));
}

class Faults : public ::testing::Test {
 protected:
  /// Position error over the span from 10 s after the fault, against the same without.
  static double Rms(const DriveRecording& drive, Navigator& navigator, double from_s) {
    testing::Rms rms;
    Play(drive, navigator, [&](std::size_t i) {
      EXPECT_TRUE(std::isfinite(navigator.Latest().position.lat_rad));
      EXPECT_TRUE(navigator.Latest().covariance.allFinite());
      if (drive.truth[i].t_s < from_s) return;
      EXPECT_TRUE(navigator.Latest().valid()) << drive.truth[i].t_s;
      rms.Add(PositionError(navigator.Latest(), drive.truth[i]).norm());
    });
    return rms.value();
  }
  static double Clean(double from_s) {
    Navigator navigator(ConfigOf(Sensors()));
    return Rms(Drive(), navigator, from_s);
  }
  static std::size_t SampleAt(double t_s) { return static_cast<std::size_t>(75.0 * t_s); }
};

TEST_F(Faults, NanAndSpikesAreCountedAndSurvived) {
  DriveRecording drive = Drive();
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  drive.imu[SampleAt(50.0)].rate_radps.x() = kNan;
  drive.imu[SampleAt(50.5)].specific_force_mps2.z() = std::numeric_limits<double>::infinity();
  drive.imu[SampleAt(51.0)].specific_force_mps2.x() += 43.0;
  drive.fixes[500].antenna.lat_rad = kNan;
  drive.fixes[501].position_cov_enu_m2(0, 0) = -1.0;
  drive.wheels[1000].speed_mps = kNan;
  Navigator navigator(ConfigOf(Sensors()));
  EXPECT_LT(Rms(drive, navigator, 61.0), 2.0 * Clean(61.0));
  EXPECT_EQ(navigator.stats().imu_invalid, 2);
  EXPECT_EQ(navigator.stats().imu_spikes, 1);
  EXPECT_EQ(navigator.stats().invalid, 3);
}

TEST_F(Faults, DuplicatesAndTimeRunningBackwardsAreDropped) {
  DriveRecording drive = Drive();
  drive.imu[SampleAt(50.0)].time = drive.imu[SampleAt(50.0) - 1].time;
  drive.imu[SampleAt(52.0)].time = drive.imu[SampleAt(52.0)].time - core::Milliseconds(300);
  Navigator navigator(ConfigOf(Sensors()));
  EXPECT_LT(Rms(drive, navigator, 62.0), 2.0 * Clean(62.0));
  EXPECT_EQ(navigator.stats().imu_duplicates, 1);
  EXPECT_EQ(navigator.stats().imu_backwards, 1);
}

TEST_F(Faults, ASecondWithoutSamplesIsSurvived) {
  DriveRecording drive = Drive();
  const auto from = static_cast<std::ptrdiff_t>(SampleAt(50.0));
  drive.imu.erase(drive.imu.begin() + from, drive.imu.begin() + from + 75);
  drive.truth.erase(drive.truth.begin() + from, drive.truth.begin() + from + 75);
  Navigator navigator(ConfigOf(Sensors()));
  EXPECT_LT(Rms(drive, navigator, 61.0), 2.0 * Clean(61.0));
  EXPECT_EQ(navigator.stats().imu_gaps, 1);
}

/// The unit's clock goes back by an hour and stays there: a new start, no NaN, no standstill for an
/// hour.
TEST_F(Faults, ClockSetBackIsANewStart) {
  const DriveRecording& drive = Drive();
  Navigator navigator(ConfigOf(Sensors()));
  constexpr auto kBack = core::Milliseconds(3'600'000);
  for (const auto& arrival : drive.InOrder()) {
    if (arrival.t_s < 40.0) {
      Give(navigator, drive, arrival);
    } else if (arrival.kind == Kind::kImu) {
      ImuSample sample = drive.imu[arrival.index];
      sample.time = sample.time - kBack;
      navigator.AddImu(sample);
    } else if (arrival.kind == Kind::kFix) {
      core::GnssFix fix = drive.fixes[arrival.index];
      fix.time = fix.time - kBack;
      navigator.AddFix(fix);
    }
  }
  ASSERT_TRUE(navigator.Latest().valid());
  EXPECT_EQ(navigator.stats().alignments, 2);
  EXPECT_LT(PositionError(navigator.Latest(), drive.truth.back()).norm(), 0.3);
}

class Allocations : public ::testing::TestWithParam<bool> {};
/// From the first sample on, alignment and late data included.
TEST_P(Allocations, NoneAfterConstruction) {
  const bool with_tape = GetParam();
  auto order = Drive().InOrder();
  for (auto& arrival : order) {
    if (arrival.kind == Kind::kFix) arrival.t_s += 0.3;
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.t_s < b.t_s; });
  FilterTape tape(1500);
  Navigator navigator(ConfigOf(Sensors()));
  if (with_tape) navigator.Record(&tape);
  const auto allocations = testing::CountAllocations([&] {
    for (const auto& arrival : order) Give(navigator, Drive(), arrival);
  });
  EXPECT_TRUE(navigator.Latest().valid());
  EXPECT_EQ(allocations, 0U);
}
INSTANTIATE_TEST_SUITE_P(RingTape, Allocations, ::testing::Bool());

}  // namespace
}  // namespace kawara::estimation
