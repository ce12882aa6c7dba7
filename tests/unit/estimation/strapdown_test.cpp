#include "estimation/strapdown.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "estimation/earth.hpp"
#include "estimation/rotation.hpp"
#include "tests/support/drive_recording.hpp"

namespace kawara::estimation {
namespace {

using testing::DrivePath;
using testing::DrivePlan;
using testing::DriveRecording;
using testing::DriveSensors;
using testing::Record;
using testing::Truth;

NominalState StateOf(const Truth& truth) {
  NominalState state;
  state.stamp = testing::DriveTime(truth.t_s);
  state.position = truth.position;
  state.velocity_ned_mps = truth.velocity_ned_mps;
  state.ned_from_body = truth.ned_from_body;
  return state;
}

ImuInterval Interval(const ImuSample& sample, const ImuSample& before, double dt_s) {
  return {.duration_s = dt_s,
          .rate_radps = sample.rate_radps,
          .specific_force_mps2 = sample.specific_force_mps2,
          .previous_rate_radps = before.rate_radps,
          .previous_specific_force_mps2 = before.specific_force_mps2};
}

/// The formula that all tests of navigation rest on, against Newton in the Earth-fixed frame:
/// f = a + 2 w x v - g, everything but g from positions alone.
TEST(DrivePath, ForceIsThatOfThePathInTheEarthFixedFrame) {
  DrivePlan plan;
  plan.speed_mps = 8.0;
  DrivePath path(plan);
  path.MoveTo(20.0 - 0.01);
  const Eigen::Vector3d before = core::EcefFromGeodetic(path.Now().position);
  path.MoveTo(20.0);
  const Truth truth = path.Now();
  const Eigen::Vector3d now = core::EcefFromGeodetic(truth.position);
  path.MoveTo(20.0 + 0.01);
  const Eigen::Vector3d after = core::EcefFromGeodetic(path.Now().position);
  const Eigen::Vector3d v = (after - before) / 0.02;
  const Eigen::Vector3d a = (after - 2.0 * now + before) / 1e-4;
  const double sl = std::sin(truth.position.lat_rad), cl = std::cos(truth.position.lat_rad);
  const double so = std::sin(truth.position.lon_rad), co = std::cos(truth.position.lon_rad);
  Eigen::Matrix3d ned_from_ecef;
  ned_from_ecef << -sl * co, -sl * so, cl, -so, co, 0.0, -cl * co, -cl * so, -sl;
  const Eigen::Vector3d coriolis = 2.0 * Eigen::Vector3d(0, 0, 7.292115e-5).cross(v);
  Eigen::Vector3d force = ned_from_ecef * (a + coriolis);
  force.z() -= NormalGravity(truth.position.lat_rad, truth.position.h_ellipsoidal_m);
  EXPECT_LT((ned_from_ecef * v - truth.velocity_ned_mps).norm(), 1e-4);
  // 1e-9 m of rounding in positions 1e-2 s apart.
  EXPECT_LT((truth.ned_from_body.conjugate() * force - truth.specific_force_mps2).norm(), 2e-4);
}

/// A minute of turns, ramps and rolling at 2 m/s and at 20: millimetres.
class StrapdownDrive : public ::testing::TestWithParam<double> {};
TEST_P(StrapdownDrive, PerfectSamplesGiveTheTruthBack) {
  DrivePlan plan;
  plan.speed_mps = GetParam();
  DriveSensors sensors;
  sensors.imu_hz = 100.0;
  const DriveRecording drive = Record(plan, sensors, 1);
  NominalState state = StateOf(drive.truth.front());
  for (std::size_t i = 1; i < drive.imu.size(); ++i) {
    Strapdown(state, Interval(drive.imu[i], drive.imu[i - 1], 0.01), 0.01, false);
  }
  const Truth& truth = drive.truth.back();
  EXPECT_LT(Displacement(truth.position, state.position).norm(), 0.0002 * GetParam() + 0.001);
  EXPECT_LT((state.velocity_ned_mps - truth.velocity_ned_mps).norm(), 2e-5 * GetParam() + 1e-5);
  EXPECT_LT(RotationVector(state.ned_from_body * truth.ned_from_body.conjugate()).norm(), 1e-6);
  EXPECT_EQ(state.stamp, drive.imu.back().time);
}
INSTANTIATE_TEST_SUITE_P(Speeds, StrapdownDrive, ::testing::Values(2.0, 20.0));

TEST(Strapdown, AtRestStaysAtRest) {
  DrivePlan plan;
  plan.stops = {{-10.0, 1000.0}};
  DriveSensors sensors;
  const DriveRecording drive = Record(plan, sensors, 1);
  NominalState state = StateOf(drive.truth.front());
  const double dt_s = 1.0 / sensors.imu_hz;
  for (std::size_t i = 1; i < drive.imu.size(); ++i) {
    Strapdown(state, Interval(drive.imu[i], drive.imu[i - 1], dt_s), dt_s, false);
  }
  EXPECT_LT(state.velocity_ned_mps.norm(), 1e-8);
  EXPECT_LT(Displacement(plan.start, state.position).norm(), 1e-6);
}

/// Held, it does not turn whatever the gyros say, and still feels gravity.
TEST(Strapdown, HeldAttitudeStands) {
  NominalState state;
  state.position = DrivePlan().start;
  const ImuInterval imu{
      .duration_s = 0.01,
      .rate_radps = {0.3, -0.2, 0.1},
      .specific_force_mps2 = {0.0, 0.0, -NormalGravity(state.position.lat_rad, 60.0)},
      .previous_rate_radps = {0.2, 0.2, 0.2},
      .previous_specific_force_mps2 = {0.1, 0.0, -9.0}};
  for (int i = 0; i < 1000; ++i) Strapdown(state, imu, 0.01, true);
  EXPECT_EQ(state.ned_from_body.angularDistance(Eigen::Quaterniond::Identity()), 0.0);
  EXPECT_LT(state.velocity_ned_mps.norm(), 1e-6);
}

/// The axis of a body describes a cone of half angle a with rate w: the attitude is a formula, and
/// rates integrated alone would drift by w (1 - cos a), here 5.6 deg a minute. Two-sample coning
/// leaves a hundredth of it.
TEST(Strapdown, ConingMotionDoesNotDrift) {
  constexpr double kHalfAngle = 1.0 * core::kRadFromDeg;
  constexpr double kTurns = 10.0 * 2.0 * core::kPi;  // rad/s
  constexpr double kStep = 0.01;
  const double sine = std::sin(kHalfAngle);
  const double drift = 2.0 * kTurns * std::pow(std::sin(0.5 * kHalfAngle), 2);  // rad/s
  const auto attitude = [&](double t) {
    return Rotation(kHalfAngle * Eigen::Vector3d(std::cos(kTurns * t), std::sin(kTurns * t), 0.0));
  };
  // Body rate of that attitude: w sin a (-sin wt, cos wt, 0) - w (1 - cos a) z.
  const auto mean_rate = [&](double t0, double t1) -> Eigen::Vector3d {
    return Eigen::Vector3d(sine * (std::cos(kTurns * t1) - std::cos(kTurns * t0)),
                           sine * (std::sin(kTurns * t1) - std::sin(kTurns * t0)),
                           -drift * (t1 - t0)) /
           (t1 - t0);
  };
  NominalState state;
  state.position = {0.0, 0.0, 0.0};
  state.ned_from_body = attitude(0.0);
  for (int i = 0; i < 6000; ++i) {
    const double t = kStep * i;
    const Eigen::Vector3d earth_before = attitude(t - 0.5 * kStep).conjugate() * EarthRateNed(0.0);
    const Eigen::Vector3d earth = attitude(t + 0.5 * kStep).conjugate() * EarthRateNed(0.0);
    const ImuInterval imu{.duration_s = kStep,
                          .rate_radps = mean_rate(t, t + kStep) + earth,
                          .specific_force_mps2 = {0.0, 0.0, -9.78},
                          .previous_rate_radps = mean_rate(t - kStep, t) + earth_before,
                          .previous_specific_force_mps2 = {0.0, 0.0, -9.78}};
    Strapdown(state, imu, kStep, false);
    state.velocity_ned_mps.setZero();
  }
  const double angle = RotationVector(state.ned_from_body * attitude(60.0).conjugate()).norm();
  EXPECT_GT(drift * 60.0, 5.0 * core::kRadFromDeg * 0.1);
  EXPECT_LT(angle, 0.05 * drift * 60.0);
}

}  // namespace
}  // namespace kawara::estimation
