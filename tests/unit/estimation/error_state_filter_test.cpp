#include "estimation/error_state_filter.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "estimation/rotation.hpp"

namespace kawara::estimation {
namespace {

ErrorCovariance RandomCovariance(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  ErrorCovariance root;
  for (int i = 0; i < root.size(); ++i) root.data()[i] = 0.1 * normal(random);
  ErrorCovariance p = root * root.transpose();
  return 0.5 * (p + p.transpose().eval());
}

NominalState SomeState() {
  NominalState s;
  s.stamp = core::GpsTime::FromNs(1'400'000'000'000'000'000);
  s.position = {0.62, 2.4, 60.0};
  s.velocity_ned_mps = {2.0, -1.0, 0.2};
  s.ned_from_body = Rotation({0.05, -0.08, 1.2});
  s.gyro_bias_radps = {0.01, -0.02, 0.005};
  s.accel_bias_mps2 = {0.1, 0.05, -0.08};
  s.gyro_scale = {0.01, -0.005, 0.008};
  s.accel_scale = {0.002, 0.003, -0.001};
  s.gyro_cross = {0.004, -0.006};
  return s;
}

ImuInterval SomeInterval() {
  const Eigen::Vector3d rate(0.1, -0.2, 0.6), force(0.8, -1.1, -9.6);
  return {.duration_s = 0.01,
          .rate_radps = rate,
          .specific_force_mps2 = force,
          .previous_rate_radps = rate,
          .previous_specific_force_mps2 = force};
}

/// The error that has to be added to `from` to get `to`, for what a step can change.
Eigen::Matrix<double, 9, 1> Difference(const NominalState& from, const NominalState& to) {
  Eigen::Matrix<double, 9, 1> d;
  d << Displacement(from.position, to.position), to.velocity_ned_mps - from.velocity_ned_mps,
      RotationVector(to.ned_from_body * from.ned_from_body.conjugate());
  return d;
}

/// F by moving the nominal state itself, error by error.
ErrorCovariance NumericalTransition(const NominalState& state, const ImuInterval& imu, double dt_s,
                                    bool hold) {
  ErrorCovariance f = ErrorCovariance::Identity();
  for (int column = 0; column < kErrorStates; ++column) {
    const double step = column < kVelocity ? 1.0 : 1e-4;
    ErrorVector error = ErrorVector::Zero();
    error(column) = step;
    NominalState plus = state, minus = state;
    plus.Correct(error);
    minus.Correct(-error);
    Strapdown(plus, imu, dt_s, hold);
    Strapdown(minus, imu, dt_s, hold);
    f.block<9, 1>(0, column) = Difference(minus, plus) / (2.0 * step);
  }
  return f;
}

class Propagation : public ::testing::TestWithParam<bool> {};
/// Terms that the class drops, and those of second order in a step, stay under 0.2 % of the
/// deviations. Taken after some seconds: the derivatives by the scales follow a mean of late.
TEST_P(Propagation, CovarianceIsTheDenseProduct) {
  const bool hold = GetParam();
  const ImuNoise noise{.gyro_arw_rad_rts = 6e-4,
                       .accel_vrw_mps_rts = 2e-3,
                       .gyro_bias_rw = 2e-5,
                       .accel_bias_rw = 2e-4};
  constexpr double kStep = 0.01;
  ErrorStateFilter filter(SomeState(), RandomCovariance(3));
  for (int i = 0; i < 300; ++i) filter.Propagate(SomeInterval(), kStep, noise, hold);
  const NominalState before = filter.state();
  const ErrorCovariance p = filter.covariance();
  filter.Propagate(SomeInterval(), kStep, noise, hold);

  const ErrorCovariance f = NumericalTransition(before, SomeInterval(), kStep, hold);
  ErrorCovariance expected = f * p * f.transpose();
  const auto add = [&](int first, double density) {
    expected.diagonal().segment<3>(first).array() += density * density * kStep;
  };
  add(kVelocity, noise.accel_vrw_mps_rts);
  if (!hold) add(kAttitude, noise.gyro_arw_rad_rts);
  add(kGyroBias, noise.gyro_bias_rw);
  add(kAccelBias, noise.accel_bias_rw);
  const ErrorVector sd = expected.diagonal().cwiseSqrt();
  const ErrorCovariance change = (expected - p).cwiseQuotient(sd * sd.transpose());
  const ErrorCovariance wrong = (filter.covariance() - expected).cwiseQuotient(sd * sd.transpose());
  EXPECT_GT(change.cwiseAbs().maxCoeff(), 0.005);  // there was something to do
  EXPECT_LT(wrong.cwiseAbs().maxCoeff(), 2e-4);
}
INSTANTIATE_TEST_SUITE_P(HeldOrNot, Propagation, ::testing::Bool());

TEST(ErrorStateFilter, CovarianceStaysExactlySymmetricAndPositive) {
  ErrorStateFilter filter(SomeState(), RandomCovariance(5));
  const ImuNoise noise{.gyro_arw_rad_rts = 6e-4, .accel_vrw_mps_rts = 2e-3};
  MeasurementRows rows;
  rows.rows = 3;
  rows.noise.diagonal().setConstant(0.01);
  rows.AddBlock(kPosition, Eigen::Matrix3d::Identity());
  for (int i = 0; i < 10000; ++i) {
    filter.Propagate(SomeInterval(), 0.01, noise, false);
    if (i % 10 == 0) filter.Update(rows, filter.Predict(rows));
  }
  EXPECT_TRUE(filter.covariance() == filter.covariance().transpose());
  const Eigen::SelfAdjointEigenSolver<ErrorCovariance> eigen(filter.covariance());
  EXPECT_GT(eigen.eigenvalues().minCoeff(), -1e-9 * eigen.eigenvalues().maxCoeff());
}

class UpdateOf : public ::testing::TestWithParam<int> {};
TEST_P(UpdateOf, IsTheTextbookUpdate) {
  const int n = GetParam();
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  MeasurementRows rows;
  rows.rows = n;
  for (const int column : {0, 1, 2, 7, 8, 21, 24, 30, 35}) {
    rows.AddColumn(column, {normal(random), normal(random), normal(random)});
  }
  rows.residual = {0.02, -0.01, 0.03};
  rows.noise << 0.02, 0.005, -0.004, 0.005, 0.03, 0.002, -0.004, 0.002, 0.04;
  const ErrorCovariance p = RandomCovariance(7);
  ErrorStateFilter filter(SomeState(), p);
  const Innovation innovation = filter.Predict(rows);
  filter.Update(rows, innovation);

  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(n, kErrorStates);
  for (int i = 0; i < rows.columns; ++i) {
    h.col(rows.index[static_cast<std::size_t>(i)]) = rows.value.col(i).head(n);
  }
  const Eigen::VectorXd y = rows.residual.head(n);
  const Eigen::MatrixXd s = h * p * h.transpose() + rows.noise.topLeftCorner(n, n);
  const Eigen::MatrixXd gain = p * h.transpose() * s.inverse();
  const Eigen::MatrixXd keep = Eigen::MatrixXd::Identity(kErrorStates, kErrorStates) - gain * h;
  const Eigen::MatrixXd expected = keep * p;
  NominalState state = SomeState();
  state.Correct(gain * y);
  EXPECT_NEAR(innovation.nis, y.dot(s.inverse() * y), 1e-10);
  EXPECT_LT((filter.covariance() - expected).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_LT(Difference(state, filter.state()).norm(), 1e-9);
  EXPECT_LT((filter.state().accel_scale - state.accel_scale).norm(), 1e-12);
  EXPECT_NEAR(filter.state().time_offset_s, state.time_offset_s, 1e-12);
}
INSTANTIATE_TEST_SUITE_P(Rows, UpdateOf, ::testing::Values(1, 2, 3));

TEST(ErrorStateFilter, DecayTendsToItsSteadyState) {
  ErrorStateFilter filter(SomeState(), RandomCovariance(9));
  const Eigen::Vector3d variance(1.0, 4.0, 9.0);
  for (int i = 0; i < 2000; ++i) filter.Decay(kGnssColoured, {variance.data(), 3}, 0.1, 10.0);
  EXPECT_LT((filter.covariance().diagonal().segment<3>(kGnssColoured) - variance).norm(), 1e-9);
  EXPECT_LT((filter.covariance().block<3, 9>(kGnssColoured, 0).norm()), 1e-7);
}

TEST(ErrorStateFilter, ForgottenErrorsAreIndependent) {
  ErrorStateFilter filter(SomeState(), RandomCovariance(9));
  filter.Forget(kGnssColoured, {1.0, 2.0, 3.0});
  const ErrorCovariance& p = filter.covariance();
  EXPECT_EQ((p.middleRows<3>(kGnssColoured).squaredNorm()), 1.0 + 4.0 + 9.0);
  EXPECT_TRUE(p == p.transpose());
}

/// What the gyros saw while the attitude was held, made up for at once: as if it had been followed.
TEST(ErrorStateFilter, TurnMakesUpForWhatWasHeld) {
  const NominalState start = [] {
    NominalState s = SomeState();
    s.velocity_ned_mps.setZero();
    return s;
  }();
  const ErrorCovariance p = 1e-4 * RandomCovariance(9);
  const ImuNoise noise{.gyro_arw_rad_rts = 6e-4};
  const ImuInterval imu = SomeInterval();
  ErrorStateFilter followed(start, p), held(start, p);
  for (int i = 0; i < 10; ++i) {
    followed.Propagate(imu, 0.01, noise, false);
    held.Propagate(imu, 0.01, noise, true);
  }
  held.Turn(imu.rate_radps * 0.1, 0.1, noise);
  EXPECT_LT(held.state().ned_from_body.angularDistance(followed.state().ned_from_body), 1e-6);
  const Eigen::Matrix3d a = held.covariance().block<3, 3>(kAttitude, kAttitude);
  const Eigen::Matrix3d b = followed.covariance().block<3, 3>(kAttitude, kAttitude);
  EXPECT_LT((a - b).norm(), 0.02 * b.norm());
}

}  // namespace
}  // namespace kawara::estimation
