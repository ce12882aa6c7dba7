#include "estimation/smoother.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/support/counting_allocator.hpp"
#include "tests/support/drive_player.hpp"

namespace kawara::estimation {
namespace {

using testing::ConfigOf;
using testing::DriveRecording;
using testing::DriveSensors;
using testing::Give;
using testing::Play;
using testing::Record;

DriveSensors Sensors() {
  DriveSensors sensors;
  sensors.imu = *FindSensorProfile("ahrs400cc-100");
  return sensors;
}

/// 60 s with an outage of fixes from 40 s to 50 s and without wheels.
const DriveRecording& Outage() {
  static const DriveRecording drive = [] {
    DriveRecording d = Record({.duration_s = 60.0}, Sensors(), 31);
    std::erase_if(d.fixes, [](const core::GnssFix& fix) {
      const double t_s = testing::DriveSeconds(fix.time);
      return t_s > 40.0 && t_s < 50.0;
    });
    d.wheels.clear();
    return d;
  }();
  return drive;
}

std::vector<NavSolution> Smoothed(const FilterTape& tape) {
  std::vector<NavSolution> out;
  Smooth(tape, [&](const NavSolution& s) {
    out.push_back(s);
    return true;
  });
  return out;
}

/// Newest first: nothing comes after it that could change it.
TEST(Smoother, EqualsTheFilterAtTheNewestNode) {
  FilterTape tape;
  Navigator navigator(ConfigOf(Sensors()));
  navigator.Record(&tape);
  Play(Outage(), navigator);
  const auto smoothed = Smoothed(tape);
  ASSERT_GT(smoothed.size(), 3000U);
  const NavSolution& filtered = navigator.Latest();
  EXPECT_EQ(smoothed.front().time, filtered.time);
  EXPECT_LT(Displacement(smoothed.front().position, filtered.position).norm(), 1e-9);
  const Eigen::Matrix<double, 9, 9> change = smoothed.front().covariance - filtered.covariance;
  EXPECT_LT(change.norm(), 1e-5 * filtered.covariance.norm());
}

TEST(Smoother, IsFiveTimesBetterInsideAnOutage) {
  FilterTape tape;
  NavigationConfig config = ConfigOf(Sensors());
  config.constraint = ConstraintMode::kOff;  // ten seconds of nothing but the inertial unit
  Navigator navigator(config);
  navigator.Record(&tape);
  const DriveRecording& drive = Outage();
  testing::Rms filtered;
  Play(drive, navigator, [&](std::size_t i) {
    const double t_s = drive.truth[i].t_s;
    if (t_s > 40.0 && t_s < 50.0) {
      filtered.Add(testing::PositionError(navigator.Latest(), drive.truth[i]).norm());
    }
  });
  testing::Rms smoothed;
  for (const NavSolution& s : Smoothed(tape)) {
    const double t_s = testing::DriveSeconds(s.time);
    if (t_s < 40.0 || t_s > 50.0) continue;
    const auto i = static_cast<std::size_t>(std::lround(t_s * 75.0)) - 1;
    smoothed.Add(testing::PositionError(s, drive.truth[i]).norm());
  }
  EXPECT_LT(5.0 * smoothed.value(), filtered.value());
}

/// Never more, nowhere: everything the filter knew the smoother knows.
TEST(Smoother, CovarianceIsSmallerThanTheFilters) {
  FilterTape tape;
  Navigator navigator(ConfigOf(Sensors()));
  navigator.Record(&tape);
  std::vector<NavSolution> filtered;
  Play(Outage(), navigator, [&](std::size_t) {
    if (navigator.filter() != nullptr) filtered.push_back(navigator.Latest());
  });
  const auto smoothed = Smoothed(tape);
  for (std::size_t back = 0; back + 1 < std::min(filtered.size(), smoothed.size()); back += 100) {
    const NavSolution& f = filtered[filtered.size() - 1 - back];
    const NavSolution& s = smoothed[back];
    const Eigen::Matrix<double, 9, 1> excess =
        s.covariance.diagonal().cwiseQuotient(f.covariance.diagonal());
    EXPECT_LT(excess.maxCoeff(), 1.001) << back;
    EXPECT_GT(excess.minCoeff(), 0.0) << back;
  }
}

/// The textbook on a small problem: position and velocity driven by acceleration, three positions
/// measured; dense least squares over the whole trajectory says what is best.
TEST(Smoother, EqualsDenseLeastSquares) {
  constexpr int kSteps = 40;
  constexpr double kStep = 0.05;
  const ImuNoise noise{.accel_vrw_mps_rts = 0.5};
  NominalState start;
  start.stamp = testing::DriveTime(0.0);
  start.position = {0.62, 2.4, 60.0};
  ErrorCovariance p0 = 1e-12 * ErrorCovariance::Identity();
  p0.diagonal().segment<3>(kPosition).setConstant(0.5);
  p0.diagonal().segment<3>(kVelocity).setConstant(0.3);
  FilterTape tape;
  ErrorStateFilter filter(start, p0);
  filter.SetTape(&tape);
  const double gravity = 9.798;
  const ImuInterval imu{.duration_s = kStep,
                        .specific_force_mps2 = {0.0, 0.0, -gravity},
                        .previous_specific_force_mps2 = {0.0, 0.0, -gravity}};
  // Nominal north positions without any correction, to measure errors from.
  NominalState plain = start;
  std::vector<double> measured(kSteps + 1, 0.0);
  std::vector<core::Geodetic> nominal{start.position};
  for (int k = 1; k <= kSteps; ++k) {
    Strapdown(plain, imu, kStep, true);
    nominal.push_back(plain.position);
  }
  const auto is_measured = [](int k) { return k % 10 == 5; };
  for (int k = 1; k <= kSteps; ++k) {
    filter.Propagate(imu, kStep, noise, true);
    if (is_measured(k)) {
      measured[static_cast<std::size_t>(k)] = 0.4 * std::sin(0.9 * k);
      MeasurementRows rows;
      rows.rows = 1;
      rows.residual.x() =
          measured[static_cast<std::size_t>(k)] -
          Displacement(nominal[static_cast<std::size_t>(k)], filter.state().position).x();
      rows.noise(0, 0) = 0.01;
      rows.AddScalar(kPosition, 1.0);
      filter.Update(rows, filter.Predict(rows));
    }
    NavSolution node;
    node.time = filter.state().stamp;
    node.position = filter.state().position;
    node.velocity_ned_mps = filter.state().velocity_ned_mps;
    tape.Add(node, filter.covariance());
  }
  // North only: x = (position, velocity) at every step, prior, motion and measurements as rows.
  constexpr int kN = 2 * (kSteps + 1);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(kN, kN);
  Eigen::VectorXd vector = Eigen::VectorXd::Zero(kN);
  information(0, 0) = 1.0 / 0.5;
  information(1, 1) = 1.0 / 0.3;
  const double q = noise.accel_vrw_mps_rts * noise.accel_vrw_mps_rts * kStep;
  for (int k = 0; k < kSteps; ++k) {
    // Position goes on by the old velocity exactly; a tiny variance stands for "exactly".
    Eigen::VectorXd row = Eigen::VectorXd::Zero(kN);
    row(2 * k) = -1.0, row(2 * k + 1) = -kStep, row(2 * k + 2) = 1.0;
    information += row * row.transpose() / 1e-9;
    row.setZero();
    row(2 * k + 1) = -1.0, row(2 * k + 3) = 1.0;
    information += row * row.transpose() / q;
    if (is_measured(k + 1)) {
      information(2 * k + 2, 2 * k + 2) += 1.0 / 0.01;
      vector(2 * k + 2) += measured[static_cast<std::size_t>(k + 1)] / 0.01;
    }
  }
  const Eigen::MatrixXd covariance = information.inverse();
  const Eigen::VectorXd best = covariance * vector;
  int k = kSteps;
  for (const NavSolution& s : Smoothed(tape)) {
    const double north = Displacement(nominal[static_cast<std::size_t>(k)], s.position).x();
    EXPECT_NEAR(north, best(2 * k), 2e-4) << k;
    EXPECT_NEAR(s.covariance(0, 0), covariance(2 * k, 2 * k), 2e-3 * covariance(2 * k, 2 * k)) << k;
    EXPECT_NEAR(s.covariance(3, 3), covariance(2 * k + 1, 2 * k + 1),
                2e-3 * covariance(2 * k + 1, 2 * k + 1))
        << k;
    --k;
  }
  EXPECT_EQ(k, 0);
}

/// Late data rewind the tape; what is left is the tape of data in order.
TEST(FilterTape, OfLateDataIsThatOfDataInOrder) {
  NavigationConfig config = ConfigOf(Sensors());
  config.time_offset_sd_s = 0.0;
  config.gnss.velocity_delay_sd_s = 1e-6;
  FilterTape in_order_tape, late_tape;
  Navigator in_order(config), late(config);
  in_order.Record(&in_order_tape);
  late.Record(&late_tape);
  auto order = Outage().InOrder();
  for (const auto& arrival : order) Give(in_order, Outage(), arrival);
  for (auto& arrival : order) {
    if (arrival.kind == DriveRecording::Kind::kFix && arrival.t_s < 59.0) arrival.t_s += 0.3;
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.t_s < b.t_s; });
  for (const auto& arrival : order) Give(late, Outage(), arrival);
  EXPECT_EQ(late_tape.end(), in_order_tape.end());
  const auto a = Smoothed(in_order_tape), b = Smoothed(late_tape);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); i += 50) {
    EXPECT_LT(Displacement(a[i].position, b[i].position).norm(), 1e-6) << i;
  }
}

class FixedLag : public ::testing::TestWithParam<double> {};
/// A ring of some seconds says what the whole tape says, as far back as it reaches.
TEST_P(FixedLag, RingIsTheGrowingTape) {
  FilterTape growing;
  FilterTape ring(1000);
  Navigator a(ConfigOf(Sensors())), b(ConfigOf(Sensors()));
  a.Record(&growing);
  b.Record(&ring);
  Play(Outage(), a);
  Play(Outage(), b);
  const core::GpsTime t = a.Latest().time - core::DurationFromSeconds(GetParam());
  const auto from_growing = SmoothedAt(growing, t);
  const auto from_ring = SmoothedAt(ring, t);
  ASSERT_TRUE(from_growing && from_ring);
  EXPECT_EQ(Displacement(from_growing->position, from_ring->position).norm(), 0.0);
  EXPECT_TRUE(from_growing->covariance == from_ring->covariance);
  EXPECT_EQ(from_growing->time, t);
}
INSTANTIATE_TEST_SUITE_P(Seconds, FixedLag, ::testing::Values(0.011, 0.5, 2.0));

TEST(FixedLagSmoother, NothingOutsideTheTape) {
  FilterTape ring(1000);
  EXPECT_FALSE(SmoothedAt(ring, testing::DriveTime(1.0)));
  Navigator navigator(ConfigOf(Sensors()));
  navigator.Record(&ring);
  Play(Outage(), navigator);
  EXPECT_FALSE(SmoothedAt(ring, navigator.Latest().time - core::Milliseconds(30'000)));
  EXPECT_FALSE(SmoothedAt(ring, navigator.Latest().time + core::Milliseconds(100)));
}

TEST(Smoother, AllocatesNothing) {
  FilterTape ring(1000);
  Navigator navigator(ConfigOf(Sensors()));
  navigator.Record(&ring);
  Play(Outage(), navigator);
  const core::GpsTime t = navigator.Latest().time - core::Milliseconds(1500);
  bool found = false;
  EXPECT_EQ(testing::CountAllocations([&] { found = SmoothedAt(ring, t).has_value(); }), 0U);
  EXPECT_TRUE(found);
}

}  // namespace
}  // namespace kawara::estimation
