#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <string>

#include "estimation/measurement_models.hpp"

namespace kawara::estimation {
namespace {

/// A robot on a slope in a turn, everything that can be estimated off zero.
NominalState State() {
  NominalState state;
  state.position = {0.67, 2.45, 60.0};
  state.velocity_ned_mps << 1.5, -0.8, 0.1;
  state.ned_from_body = Eigen::Quaterniond(core::RotationNedFromBody({0.1, -0.08, -0.5}));
  state.gyro_bias_radps << 0.01, -0.02, 0.015;
  state.gyro_scale << 0.01, -0.005, 0.008;
  state.speed_scale = 0.02;
  state.turn_scale = 0.15;
  state.mount_pitch_rad = 0.03;
  state.mount_yaw_rad = -0.02;
  state.axle_m = 0.4;
  state.squat_rad_per_mps2 = 0.004;
  state.sideslip_rad_per_mps2 = -0.003;
  return state;
}

constexpr double kStep = 1e-5;
const Eigen::Vector3d kMeasuredRate(0.05, -0.1, 0.6);

/// What the wheels feel depends on the corrected rate.
BodyMotion Motion(const NominalState& state) {
  BodyMotion motion;
  motion.rate_radps = state.TrueRate(kMeasuredRate);
  motion.acceleration_mps2 << 0.7, 0.9, -0.1;
  return motion;
}

using Rows = std::function<MeasurementRows(const NominalState&)>;

/// Derivatives stated, as a whole matrix, against differences of the residual: it is measured minus
/// predicted, so it falls by what the prediction rises.
void ExpectDerivativesAreTrue(const Rows& rows_of, const std::string& name, double tolerance,
                              const std::set<int>& left_out = {}) {
  const NominalState state = State();
  const MeasurementRows rows = rows_of(state);
  Eigen::Matrix<double, 3, kErrorStates> stated;
  stated.setZero();
  for (int c = 0; c < rows.columns; ++c) {
    stated.col(rows.index[static_cast<std::size_t>(c)]) += rows.value.col(c);
  }
  ASSERT_TRUE(stated.allFinite()) << name;
  for (int which = 0; which < kErrorStates; ++which) {
    if (left_out.contains(which)) continue;
    ErrorVector error = ErrorVector::Zero();
    error(which) = kStep;
    NominalState plus = state, minus = state;
    plus.Correct(error);
    minus.Correct(-error);
    const Eigen::Vector3d slope =
        (rows_of(minus).residual - rows_of(plus).residual) / (2.0 * kStep);
    for (int row = 0; row < rows.rows; ++row) {
      EXPECT_NEAR(stated(row, which), slope(row), tolerance)
          << name << ": row " << row << " by error " << which;
    }
  }
}

/// A per cent of turn rate is millimetres a second at the axle: the constraint leaves it out.
const std::set<int> kRateScales{kGyroScale, kGyroScale + 1, kGyroScale + 2, kGyroCross,
                                kGyroCross + 1};

TEST(MeasurementRows, ConstraintDerivatives) {
  ExpectDerivativesAreTrue(
      [](const NominalState& s) { return ConstraintRows(s, Motion(s), 0.05, 0.05); }, "constraint",
      0.01, kRateScales);
}

TEST(MeasurementRows, ConstraintBySquatAndSideslip) {
  const NominalState state = State();
  const auto residual = [&](int which, double by) {
    ErrorVector error = ErrorVector::Zero();
    error(which) = by;
    NominalState moved = state;
    moved.Correct(error);
    return Eigen::Vector3d(ConstraintRows(moved, Motion(moved), 0.05, 0.05).residual);
  };
  const MeasurementRows rows = ConstraintRows(state, Motion(state), 0.05, 0.05);
  for (const int which : {static_cast<int>(kSquat), static_cast<int>(kSideslip)}) {
    const Eigen::Vector3d slope =
        (residual(which, -kStep) - residual(which, kStep)) / (2.0 * kStep);
    bool found = false;
    for (int c = 0; c < rows.columns; ++c) {
      if (rows.index[static_cast<std::size_t>(c)] != which) continue;
      found = true;
      EXPECT_LT((rows.value.col(c) - slope).head<2>().norm(), 1e-6) << which;
    }
    EXPECT_TRUE(found) << which;
  }
}

TEST(MeasurementRows, TurnRateDerivatives) {
  ExpectDerivativesAreTrue(
      [](const NominalState& s) { return TurnRateRows(s, kMeasuredRate, 0.7, 0.03); }, "turn rate",
      0.02);
}

TEST(MeasurementRows, ZeroVelocityDerivatives) {
  ExpectDerivativesAreTrue([](const NominalState& s) { return ZeroVelocityRows(s, 0.01); },
                           "zero velocity", 1e-6);
}

TEST(MeasurementRows, HeadingDerivatives) {
  ExpectDerivativesAreTrue([](const NominalState& s) { return HeadingRows(s, -0.4, 0.01); },
                           "heading", 1e-6);
  ExpectDerivativesAreTrue([](const NominalState& s) { return AhrsHeadingRows(s, -0.4, 0.1); },
                           "magnetic heading", 1e-6);
}

}  // namespace
}  // namespace kawara::estimation
