#include "estimation/measurement_models.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <ostream>
#include <string>

#include "estimation/earth.hpp"
#include "estimation/rotation.hpp"

namespace kawara::estimation {
namespace {

NominalState SomeState() {
  NominalState s;
  s.stamp = core::GpsTime::FromNs(1'400'000'000'000'000'000);
  s.position = {0.62, 2.4, 60.0};
  s.velocity_ned_mps = {3.0, -2.0, 0.3};
  s.ned_from_body = Rotation({0.05, -0.08, 1.2});
  s.gyro_bias_radps = {0.01, -0.02, 0.005};
  s.accel_bias_mps2 = {0.1, 0.05, -0.08};
  s.gyro_scale = {0.01, -0.005, 0.008};
  s.gnss_coloured_ned_m = {0.01, -0.02, 0.03};
  s.time_offset_s = 0.03;
  s.velocity_delay_s = 0.05;
  s.speed_scale = 0.02;
  s.turn_scale = -0.2;
  s.mount_pitch_rad = 0.03;
  s.mount_yaw_rad = -0.05;
  s.axle_m = -0.4;
  s.ahrs_heading_rad = 0.06;
  s.squat_rad_per_mps2 = 0.004;
  s.sideslip_rad_per_mps2 = -0.003;
  s.gyro_cross = {0.004, -0.006};
  return s;
}

constexpr double kShift = 0.05;
const Eigen::Vector3d kMeasuredRate(0.1, -0.2, 0.6);

/// As NavigationFilter makes it: the rate is what the state makes of the measured one.
BodyMotion MotionOf(const NominalState& state) {
  return {.rate_radps = state.TrueRate(kMeasuredRate), .acceleration_mps2 = {0.9, -1.4, 0.2}};
}

NavigationConfig SomeConfig() {
  NavigationConfig config;
  config.lever_arm_frd_m = {0.3, -0.2, -0.9};
  return config;
}

core::GnssFix SomeFix() {
  core::GnssFix fix;
  fix.rtk = core::RtkState::kFixed;
  fix.antenna = Displaced(SomeState().position, {0.5, 0.4, -1.1});
  fix.position_cov_enu_m2 << 4e-4, 1e-4, 0.0, 1e-4, 9e-4, 2e-4, 0.0, 2e-4, 16e-4;
  fix.velocity_enu_mps = {-2.1, 3.2, 0.1};
  fix.velocity_sd_enu_mps = {0.1, 0.2, 0.3};
  return fix;
}

struct Model {
  std::string name;
  std::function<MeasurementRows(const NominalState&)> rows;
  std::vector<int> knows;  ///< errors that must have a derivative
};
std::ostream& operator<<(std::ostream& out, const Model& m) { return out << m.name; }

std::vector<Model> Models() {
  return {
      {"Position",
       [](const NominalState& s) {
         return PositionRows(s, MotionOf(s), SomeFix(), kShift, SomeConfig());
       },
       {kPosition, kVelocity, kAttitude, kGnssColoured, kTimeOffset}},
      {"GnssVelocity",
       [](const NominalState& s) {
         return GnssVelocityRows(s, MotionOf(s), SomeFix(), kShift, SomeConfig());
       },
       {kVelocity, kAttitude, kGyroBias, kTimeOffset, kVelocityDelay}},
      {"Heading", [](const NominalState& s) { return HeadingRows(s, 1.1, 0.01); }, {kAttitude + 2}},
      {"AhrsHeading",
       [](const NominalState& s) { return AhrsHeadingRows(s, 1.1, 0.05); },
       {kAttitude + 2, kAhrsHeading}},
      {"Level",
       [](const NominalState& s) {
         return LevelRows(s, core::Attitude{0.02, -0.03, 0.0}, 0.03);
       },
       {kAttitude, kAttitude + 1}},
      {"Speed",
       [](const NominalState& s) { return SpeedRows(s, MotionOf(s), 3.3, 0.05); },
       {kVelocity, kAttitude, kSpeedScale, kMountPitch, kMountYaw, kAxle, kSquat, kSideslip}},
      {"Constraint",
       [](const NominalState& s) { return ConstraintRows(s, MotionOf(s), 0.05, 0.06); },
       {kVelocity, kAttitude, kGyroBias + 2, kMountPitch, kMountYaw, kAxle, kSquat, kSideslip}},
      {"TurnRate",
       [](const NominalState& s) { return TurnRateRows(s, kMeasuredRate, 0.5, 0.03); },
       {kGyroBias + 2, kGyroScale + 2, kTurnScale}},
      {"ZeroVelocity",
       [](const NominalState& s) { return ZeroVelocityRows(s, 0.01); },
       {kVelocity}},
      {"ZeroRate",
       [](const NominalState& s) {
         return ZeroRateRows(s, Eigen::Vector3d(0.01, -0.02, 0.005), 0.001);
       },
       {kGyroBias}},
  };
}

Eigen::Matrix<double, 3, kErrorStates> Dense(const MeasurementRows& rows) {
  Eigen::Matrix<double, 3, kErrorStates> h;
  h.setZero();
  for (int i = 0; i < rows.columns; ++i) {
    h.col(rows.index[static_cast<std::size_t>(i)]).head(rows.rows) +=
        rows.value.col(i).head(rows.rows);
  }
  return h;
}

class Derivatives : public ::testing::TestWithParam<Model> {};

/// How large each error may well be.
ErrorVector TypicalErrors() {
  ErrorVector sd = ErrorVector::Constant(0.01);
  sd.segment<9>(0).setConstant(0.3);
  sd.segment<3>(kAccelBias).setConstant(0.1);
  sd.segment<3>(kGnssColoured).setConstant(0.03);
  sd.segment<2>(kTimeOffset).setConstant(0.15);
  sd(kSpeedScale) = 0.03;
  sd(kTurnScale) = 0.3;
  sd.segment<2>(kMountPitch).setConstant(0.1);
  sd(kAxle) = 1.0;
  sd(kAhrsHeading) = 0.2;
  sd.segment<2>(kSquat).setConstant(0.05);
  return sd;
}

/// residual = measured - predicted, so the residual falls by H times an error added to the state.
/// What a model leaves out by intent (a scale of the gyros times a lever arm) may be worth 5 mm,
/// 5 mm/s or 5 mrad at most.
TEST_P(Derivatives, AreThoseOfTheResidual) {
  const NominalState state = SomeState();
  const MeasurementRows rows = GetParam().rows(state);
  const Eigen::Matrix<double, 3, kErrorStates> h = Dense(rows);
  const ErrorVector typical = TypicalErrors();
  for (int column = 0; column < kErrorStates; ++column) {
    ErrorVector error = ErrorVector::Zero();
    error(column) = 1e-3 * typical(column);
    NominalState plus = state, minus = state;
    plus.Correct(error);
    minus.Correct(-error);
    const Eigen::Vector3d numerical =
        (GetParam().rows(minus).residual - GetParam().rows(plus).residual) / (2.0 * error(column));
    for (int row = 0; row < rows.rows; ++row) {
      EXPECT_NEAR(h(row, column), numerical(row), 0.005 / typical(column))
          << "row " << row << " error " << column;
    }
  }
}

TEST_P(Derivatives, OfEveryErrorItIsMeantToShowAreThere) {
  const Eigen::Matrix<double, 3, kErrorStates> h = Dense(GetParam().rows(SomeState()));
  for (const int column : GetParam().knows) EXPECT_GT(h.col(column).norm(), 1e-3) << column;
}

TEST_P(Derivatives, NoiseIsACovariance) {
  const MeasurementRows rows = GetParam().rows(SomeState());
  const int n = rows.rows;
  const Eigen::Matrix3d& noise = rows.noise;
  EXPECT_EQ(noise, noise.transpose());
  for (int i = 0; i < n; ++i) EXPECT_GT(noise(i, i), 0.0);
  EXPECT_GT(noise.topLeftCorner(n, n).determinant(), 0.0);
}

INSTANTIATE_TEST_SUITE_P(AllModels, Derivatives, ::testing::ValuesIn(Models()),
                         [](const auto& model) { return model.param.name; });

TEST(MeasurementModels, PerfectMeasurementsLeaveNoResidual) {
  const NominalState s = SomeState();
  const BodyMotion motion = MotionOf(s);
  const NavigationConfig config = SomeConfig();
  core::GnssFix fix = SomeFix();
  fix.antenna =
      Displaced(s.position, s.ned_from_body * config.lever_arm_frd_m + s.gnss_coloured_ned_m);
  EXPECT_LT(PositionRows(s, motion, fix, s.time_offset_s, config).residual.norm(), 1e-8);
  const Eigen::Vector3d v =
      s.velocity_ned_mps + s.ned_from_body * motion.rate_radps.cross(config.lever_arm_frd_m);
  fix.velocity_enu_mps = {v.y(), v.x(), -v.z()};
  const double shift_s = s.time_offset_s + s.velocity_delay_s;
  EXPECT_LT(GnssVelocityRows(s, motion, fix, shift_s, config).residual.norm(), 1e-12);
  const Eigen::Vector3d vehicle = VehicleVelocity(s, motion);
  EXPECT_NEAR(SpeedRows(s, motion, 1.02 * vehicle.x(), 0.1).residual.x(), 0.0, 1e-12);
}

/// A yaw of +179 deg against a heading of -179: 2 deg, not 358.
TEST(MeasurementModels, HeadingsDifferTheShortWay) {
  NominalState s;
  s.ned_from_body = Rotation({0.0, 0.0, 179.0 * core::kRadFromDeg});
  const MeasurementRows rows = HeadingRows(s, -179.0 * core::kRadFromDeg, 0.01);
  EXPECT_NEAR(rows.residual.x(), 2.0 * core::kRadFromDeg, 1e-12);
}

TEST(MeasurementModels, StatedVarianceHasAFloorAndIsInNed) {
  core::GnssFix fix;
  fix.position_cov_enu_m2.diagonal() << 4.0, 9.0, 0.0;
  GnssErrors errors;
  errors.min_position_sd_m = 0.5;
  EXPECT_EQ(StatedVarianceNed(fix, errors), Eigen::Vector3d(9.0, 4.0, 0.25));
}

TEST(MeasurementModels, GradeOfEveryRtkState) {
  EXPECT_EQ(GradeOf(core::RtkState::kFixed), GnssGrade::kFixed);
  EXPECT_EQ(GradeOf(core::RtkState::kFloat), GnssGrade::kFloat);
  for (const auto rtk : {core::RtkState::kAutonomous, core::RtkState::kCodeDifferential,
                         core::RtkState::kDeadReckoning}) {
    EXPECT_EQ(GradeOf(rtk), GnssGrade::kCode);
  }
}

}  // namespace
}  // namespace kawara::estimation
