#include "estimation/pose_composer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/counting_allocator.hpp"

namespace kawara::estimation {
namespace {

using core::DurationFromSeconds;
using core::GpsTime;
using core::kRadFromDeg;
using core::Milliseconds;
using core::MonoTime;
using core::Seconds;

/// A vehicle on a circle (or straight, radius 0), its antenna and its instruments, without noise.
struct Vehicle {
  core::Geodetic centre{38.26 * kRadFromDeg, 140.84 * kRadFromDeg, 60.0};
  double speed_mps = 5.0;
  double radius_m = 0.0;
  double start_yaw_rad = 0.6;
  core::Attitude tilt{0.05, -0.08, 0.0};
  Eigen::Vector3d lever_frd_m{0.12, -0.18, -0.92};
  double declination_rad = -8.0 * kRadFromDeg;
  GpsTime gps_start = GpsTime::FromNs(1'400'000'000'000'000'000);
  MonoTime mono_start = MonoTime::FromNs(1'000'000'000'000);
  double drift_ppm = 20.0;

  double TurnRate() const { return radius_m > 0.0 ? speed_mps / radius_m : 0.0; }
  core::Attitude AttitudeAt(double t) const {
    return {tilt.roll_rad, tilt.pitch_rad, core::WrapPi(start_yaw_rad + TurnRate() * t)};
  }
  core::Geodetic PositionAt(double t) const {
    const double yaw = start_yaw_rad + TurnRate() * t;
    if (radius_m == 0.0) {
      return core::OffsetNed(centre,
                             {speed_mps * t * std::cos(yaw), speed_mps * t * std::sin(yaw), 0});
    }
    return core::OffsetNed(centre, {radius_m * std::sin(yaw), -radius_m * std::cos(yaw), 0});
  }
  core::Geodetic AntennaAt(double t) const {
    return core::OffsetNed(PositionAt(t), core::RotationNedFromBody(AttitudeAt(t)) * lever_frd_m);
  }
  GpsTime Gps(double t) const { return gps_start + DurationFromSeconds(t); }
  MonoTime Mono(double t) const {
    return mono_start + DurationFromSeconds(t * (1.0 + drift_ppm * 1e-6));
  }

  core::GnssFix FixAt(double t) const {
    core::GnssFix fix;
    fix.time = Gps(t);
    fix.arrival = Mono(t + 0.05);
    fix.rtk = core::RtkState::kFixed;
    fix.has_position = true;
    fix.antenna = AntennaAt(t);
    fix.position_cov_enu_m2 = Eigen::Vector3d(1e-4, 1e-4, 4e-4).asDiagonal();
    fix.has_velocity = true;
    const Eigen::Vector3d ned = core::NedBetween(AntennaAt(t - 0.005), AntennaAt(t + 0.005)) / 0.01;
    fix.velocity_enu_mps << ned.y(), ned.x(), -ned.z();
    fix.velocity_sd_enu_mps.setConstant(0.03);
    return fix;
  }
  core::AhrsSample AhrsAt(double t) const {
    core::AhrsSample sample;
    sample.sampled = Mono(t);
    sample.arrival = Mono(t + 0.01);
    sample.has_attitude = true;
    sample.attitude = AttitudeAt(t);
    sample.attitude.yaw_rad = core::WrapPi(sample.attitude.yaw_rad - declination_rad);  // magnetic
    sample.rate_radps =
        core::RotationNedFromBody(AttitudeAt(t)).transpose() * Eigen::Vector3d(0, 0, TurnRate());
    return sample;
  }
};

PoseComposerConfig ConfigFor(const Vehicle& v) {
  PoseComposerConfig config;
  config.lever_arm_frd_m = v.lever_frd_m;
  config.heading.declination_rad = v.declination_rad;
  return config;
}

/// Clock, fixes at 5 Hz and attitude at 60 Hz up to `end` (fixes arrive 50 ms after their epoch).
struct Robot {
  Robot(const Vehicle& v, const PoseComposerConfig& config, double latency_sigma_s = 1e-4)
      : vehicle(v), clock(Clock(latency_sigma_s)), composer(config) {}
  static GpsTimelineConfig Clock(double latency_sigma_s) {
    GpsTimelineConfig config;
    config.envelope.min_latency_s = 0.05;
    config.envelope.min_latency_sigma_s = latency_sigma_s;
    return config;
  }
  void Run(double begin, double end, double fix_until = 1e9, double fix_period = 0.2) {
    double next_fix = std::ceil(begin / fix_period - 1e-9) * fix_period;
    for (double t = begin; t < end - 1e-9; t += 1.0 / 60.0) {
      for (; next_fix + 0.05 <= t && next_fix < fix_until; next_fix += fix_period) {
        clock.AddEpoch(vehicle.Gps(next_fix), vehicle.Mono(next_fix + 0.05));
        composer.AddFix(edit ? edit(vehicle.FixAt(next_fix)) : vehicle.FixAt(next_fix), clock);
      }
      if (attitude) composer.AddAhrs(edit_ahrs ? edit_ahrs(vehicle.AhrsAt(t)) : vehicle.AhrsAt(t));
    }
  }
  double PositionErrorM(const core::Pose& pose, double t) const {
    return core::NedBetween(vehicle.PositionAt(t), pose.position).norm();
  }
  double YawErrorRad(const core::Pose& pose, double t) const {
    return std::abs(core::WrapPi(pose.attitude.yaw_rad - vehicle.AttitudeAt(t).yaw_rad));
  }
  Vehicle vehicle;
  GpsTimeline clock;
  PoseComposer composer;
  bool attitude = true;
  core::GnssFix (*edit)(core::GnssFix) = nullptr;
  core::AhrsSample (*edit_ahrs)(core::AhrsSample) = nullptr;
};

TEST(PoseComposer, NothingIsInvalid) {
  const PoseComposer composer;
  const GpsTimeline clock;
  EXPECT_FALSE(composer.At(MonoTime::FromNs(5), clock).valid);
  EXPECT_FALSE(composer.At(GpsTime::FromNs(5), clock).valid);
}

TEST(PoseComposer, OnTheFixTheReferencePointIsExact) {
  const Vehicle v;
  Robot robot(v, ConfigFor(v));
  robot.Run(0, 10);
  const core::Pose pose = robot.composer.At(v.Gps(9.0), robot.clock);
  ASSERT_TRUE(pose.valid);
  EXPECT_LT(robot.PositionErrorM(pose, 9.0), 2e-3);
  EXPECT_LT(robot.YawErrorRad(pose, 9.0), 1e-3);
  EXPECT_NEAR(pose.attitude.roll_rad, v.tilt.roll_rad, 1e-6);
  EXPECT_NEAR(pose.attitude.pitch_rad, v.tilt.pitch_rad, 1e-6);
  EXPECT_EQ(pose.rtk, core::RtkState::kFixed);
  EXPECT_NEAR(pose.gnss_age_s, 0.0, 1e-9);
}

class PoseOnCircle : public ::testing::TestWithParam<double> {};
/// Between fixes of 5 Hz on circles down to 10 m at 5 m/s (2.5 m/s^2 across): a centimetre.
TEST_P(PoseOnCircle, InterpolationFollowsTheCurve) {
  Vehicle v;
  v.radius_m = GetParam();
  Robot robot(v, ConfigFor(v));
  robot.Run(0, 20);
  for (double t = 17.0; t < 19.5; t += 0.0137) {
    const core::Pose pose = robot.composer.At(v.Gps(t), robot.clock);
    ASSERT_TRUE(pose.valid);
    EXPECT_LT(robot.PositionErrorM(pose, t), 0.01) << t;
    EXPECT_LT(robot.YawErrorRad(pose, t), 0.02) << t;
  }
}
/// Half a second beyond the last fix the gyro bends the way: a straight line would be 0.31 m off on
/// 10 m.
TEST_P(PoseOnCircle, ExtrapolationFollowsTheGyro) {
  Vehicle v;
  v.radius_m = GetParam();
  Robot robot(v, ConfigFor(v));
  robot.Run(0, 20, 19.3);
  const core::Pose pose = robot.composer.At(v.Mono(19.7), robot.clock);
  ASSERT_TRUE(pose.valid);
  EXPECT_NEAR(pose.gnss_age_s, 0.5, 0.01);
  EXPECT_LT(robot.PositionErrorM(pose, 19.7), 0.03);
  EXPECT_NEAR(pose.velocity_enu_mps.head<2>().norm(), v.speed_mps, 0.05);
}
INSTANTIATE_TEST_SUITE_P(RadiusM, PoseOnCircle, ::testing::Values(0.0, 10.0, 30.0));

TEST(PoseComposer, CovarianceGrowsBeyondTheLastFixUntilItEnds) {
  const Vehicle v;
  Robot robot(v, ConfigFor(v));
  robot.Run(0, 14, 9.9);
  double last = 0.0;
  for (const double t : {9.85, 10.0, 10.5, 11.0, 11.7}) {
    const core::Pose pose = robot.composer.At(v.Mono(t), robot.clock);
    ASSERT_TRUE(pose.valid) << t;
    EXPECT_GT(pose.position_cov_enu_m2.trace(), last) << t;
    last = pose.position_cov_enu_m2.trace();
  }
  const core::Pose lost = robot.composer.At(v.Mono(13.0), robot.clock);
  EXPECT_FALSE(lost.valid);
  EXPECT_NEAR(lost.gnss_age_s, 3.2, 0.05);
  EXPECT_LT(robot.YawErrorRad(lost, 13.0), 0.01);  // the attitude is still there
}

TEST(PoseComposer, UncertainTimeIsInTheCovarianceAlongTheWay) {
  const Vehicle v;
  double cov[2];
  for (int i = 0; i < 2; ++i) {
    Robot robot(v, ConfigFor(v), i == 0 ? 1e-4 : 0.02);
    robot.Run(0, 30);
    const core::Pose pose = robot.composer.At(v.Mono(29.0), robot.clock);
    const Eigen::Vector3d along = pose.velocity_enu_mps.normalized();
    cov[i] = along.dot(pose.position_cov_enu_m2 * along);
  }
  EXPECT_NEAR(cov[1] - cov[0], std::pow(0.02 * v.speed_mps, 2), 1e-3);
}

TEST(PoseComposer, ALateFixFindsItsPlace) {
  const Vehicle v;
  Robot in_order(v, ConfigFor(v)), late(v, ConfigFor(v));
  for (Robot* robot : {&in_order, &late}) robot->Run(0, 9.01);
  const std::vector<double> times{9.0, 9.2, 9.4, 9.6};
  for (const double t : times) in_order.composer.AddFix(v.FixAt(t), in_order.clock);
  for (const double t : {9.0, 9.4, 9.6, 9.2}) late.composer.AddFix(v.FixAt(t), late.clock);
  const core::Pose a = in_order.composer.At(v.Gps(9.3), in_order.clock);
  const core::Pose b = late.composer.At(v.Gps(9.3), late.clock);
  EXPECT_EQ(a.position.lat_rad, b.position.lat_rad);
  EXPECT_EQ(a.position.lon_rad, b.position.lon_rad);
  EXPECT_EQ(late.composer.stats().fixes_late_inserted, 1);
}

TEST(PoseComposer, TooLateAndRepeatedAndEmptyFixesAreCounted) {
  const Vehicle v;
  Robot robot(v, ConfigFor(v));
  robot.Run(0, 10);
  const auto before = robot.composer.stats();
  robot.composer.AddFix(v.FixAt(7.0), robot.clock);
  robot.composer.AddFix(v.FixAt(9.6), robot.clock);
  core::GnssFix empty = v.FixAt(10.2);
  empty.has_position = false;
  robot.composer.AddFix(empty, robot.clock);
  core::GnssFix nan = v.FixAt(10.2);
  nan.antenna.lat_rad = std::nan("");
  robot.composer.AddFix(nan, robot.clock);
  const auto& after = robot.composer.stats();
  EXPECT_EQ(after.fixes_too_late - before.fixes_too_late, 1);
  EXPECT_EQ(after.fixes_repeated - before.fixes_repeated, 1);
  EXPECT_EQ(after.fixes_empty - before.fixes_empty, 2);
  EXPECT_EQ(after.fixes, before.fixes);
}

TEST(PoseComposer, AReceiverSetBackIsBelievedAfterAWhile) {
  Vehicle v;
  Robot robot(v, ConfigFor(v));
  core::GnssFix future = v.FixAt(3600.0);
  robot.composer.AddFix(future, robot.clock);
  robot.Run(0, 10);
  EXPECT_TRUE(robot.composer.At(v.Gps(9.0), robot.clock).valid);
}

TEST(PoseComposer, WithoutVelocityPositionsGiveIt) {
  const Vehicle v;
  Robot robot(v, ConfigFor(v));
  robot.edit = [](core::GnssFix fix) {
    fix.has_velocity = false;
    return fix;
  };
  robot.Run(0, 10, 9.5);
  const core::Pose between = robot.composer.At(v.Gps(9.1), robot.clock);
  const core::Pose beyond = robot.composer.At(v.Gps(9.7), robot.clock);
  ASSERT_TRUE(between.valid && beyond.valid);
  EXPECT_LT(robot.PositionErrorM(between, 9.1), 0.01);
  EXPECT_LT(robot.PositionErrorM(beyond, 9.7), 0.02);
  EXPECT_GT(beyond.position_cov_enu_m2.trace(), between.position_cov_enu_m2.trace());
}

TEST(PoseComposer, DeclinationIsAppliedOnceEastPositive) {
  Vehicle v;
  v.speed_mps = 0.0;  // course cannot help
  v.declination_rad = 10.0 * kRadFromDeg;
  Robot robot(v, ConfigFor(v));
  robot.edit_ahrs = [](core::AhrsSample s) {
    s.attitude.yaw_rad = 30.0 * kRadFromDeg;
    return s;
  };
  robot.Run(0, 5);
  EXPECT_NEAR(robot.composer.At(v.Mono(4.0), robot.clock).attitude.yaw_rad, 40.0 * kRadFromDeg,
              1e-6);
}

TEST(PoseComposer, CourseCorrectsADisturbedCompass) {
  Vehicle v;
  Robot robot(v, ConfigFor(v));
  robot.edit_ahrs = [](core::AhrsSample s) {
    s.attitude.yaw_rad = core::WrapPi(s.attitude.yaw_rad + 6.0 * kRadFromDeg);
    return s;
  };
  robot.Run(0, 60);
  EXPECT_LT(robot.YawErrorRad(robot.composer.At(v.Mono(59.0), robot.clock), 59.0),
            1.0 * kRadFromDeg);
}

TEST(PoseComposer, DrivingBackwardsDoesNotTurnTheRobotRound) {
  Vehicle v;
  v.speed_mps = -2.0;
  Robot robot(v, ConfigFor(v));
  robot.Run(0, 30);
  EXPECT_LT(robot.YawErrorRad(robot.composer.At(v.Mono(29.0), robot.clock), 29.0),
            1.0 * kRadFromDeg);
}

TEST(PoseComposer, WithoutCompassTheFirstRunGivesTheHeadingAndTheGyroKeepsIt) {
  Vehicle v;
  PoseComposerConfig config = ConfigFor(v);
  config.heading.use_magnetic = false;
  Robot robot(v, config);
  robot.edit_ahrs = [](core::AhrsSample s) {
    s.has_attitude = false;
    return s;
  };
  const core::AhrsSample first = v.AhrsAt(-0.1);
  robot.composer.AddAhrs(first);
  robot.Run(0, 0.04);
  EXPECT_NEAR(robot.composer.At(v.Mono(0.03), robot.clock).attitude_sd_rad.z(), core::kPi, 1e-9);
  robot.Run(0.04, 10);
  EXPECT_LT(robot.YawErrorRad(robot.composer.At(v.Mono(9.0), robot.clock), 9.0), 0.01);
  // Now it turns on the spot by 90 degrees, without a course.
  robot.vehicle.speed_mps = 0.0;
  for (double t = 10.0; t < 11.0; t += 0.01) {
    core::AhrsSample s = v.AhrsAt(t);
    s.has_attitude = false;
    s.rate_radps << 0, 0, core::kPi / 2;
    robot.composer.AddAhrs(s);
  }
  const core::Pose turned = robot.composer.At(v.Mono(10.99), robot.clock);
  EXPECT_NEAR(core::WrapPi(turned.attitude.yaw_rad - v.start_yaw_rad), core::kPi / 2, 0.05);
}

TEST(PoseComposer, TwoAntennasRule) {
  Vehicle v;
  v.speed_mps = 0.0;
  Robot robot(v, ConfigFor(v));
  robot.edit_ahrs = [](core::AhrsSample s) {
    s.attitude.yaw_rad = core::WrapPi(s.attitude.yaw_rad + 0.5);  // steel
    return s;
  };
  robot.edit = [](core::GnssFix fix) {
    fix.has_heading = true;
    fix.heading_rad = Vehicle().start_yaw_rad;
    return fix;
  };
  robot.Run(0, 20);
  EXPECT_LT(robot.YawErrorRad(robot.composer.At(v.Mono(19.0), robot.clock), 19.0), 0.01);
}

TEST(PoseComposer, WithoutAttitudeUnitLevelAndCourse) {
  const Vehicle v;
  Robot robot(v, ConfigFor(v));
  robot.attitude = false;
  robot.Run(0, 10);
  const core::Pose pose = robot.composer.At(v.Gps(9.0), robot.clock);
  ASSERT_TRUE(pose.valid);
  EXPECT_LT(robot.YawErrorRad(pose, 9.0), 1e-3);
  EXPECT_GT(pose.attitude_sd_rad.x(), 0.05);
  EXPECT_LT(robot.PositionErrorM(pose, 9.0), 0.2);  // the lever arm stands upright
}

TEST(PoseComposer, AttitudeIsCarriedOnByTheGyroAndThenGivenUp) {
  Vehicle v;
  v.radius_m = 5.0;
  Robot robot(v, ConfigFor(v));
  robot.Run(0, 10);
  const core::Pose soon = robot.composer.At(v.Mono(10.2), robot.clock);
  EXPECT_LT(robot.YawErrorRad(soon, 10.2), 0.05);
  const core::Pose late = robot.composer.At(v.Mono(10.6), robot.clock);
  EXPECT_GT(late.attitude_sd_rad.x(), soon.attitude_sd_rad.x());
}

TEST(PoseComposer, NeverAllocates) {
  Vehicle v;
  v.radius_m = 20.0;
  Robot robot(v, ConfigFor(v));
  robot.Run(0, 1);
  const std::uint64_t allocations = kawara::testing::AllocationsOfThisThread();
  robot.Run(1, 10);
  for (double t = 8.0; t < 12.5; t += 0.1) robot.composer.At(v.Mono(t), robot.clock);
  robot.composer.AddAhrsAndCompose(v.AhrsAt(10.1), robot.clock);
  EXPECT_EQ(kawara::testing::AllocationsOfThisThread(), allocations);
}

}  // namespace
}  // namespace kawara::estimation
