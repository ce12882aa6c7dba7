#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <string>

#include "sim/vehicle/imu_errors.hpp"
#include "sim/vehicle/normal_gravity.hpp"
#include "sim/vehicle/simulate_drive.hpp"
#include "tests/unit/sim_vehicle/test_drives.hpp"

namespace kawara::sim {
namespace {

TEST(NormalGravity, KnownValues) {
  // Equator and pole: defining values of WGS 84. 45 degrees, and what a kilometre takes away
  // (0.3086 mGal/m): textbook values.
  EXPECT_NEAR(NormalGravityNed({0.0, 0.0, 0.0}).z(), 9.7803253359, 1e-9);
  EXPECT_NEAR(NormalGravityNed({core::kPi / 2.0, 0.0, 0.0}).z(), 9.8321849378, 1e-8);
  EXPECT_NEAR(NormalGravityNed({core::kPi / 4.0, 0.0, 0.0}).z(), 9.80620, 1e-5);
  EXPECT_NEAR(NormalGravityNed({core::kPi / 4.0, 0.0, 1000.0}).z() -
                  NormalGravityNed({core::kPi / 4.0, 0.0, 0.0}).z(),
              -3.086e-3, 2e-6);
}

TEST(TrueInertial, AtRestItFeelsGravityUpwardsAndTheEarthTurning) {
  VehicleConfig robot = Robot();
  robot.vibration.idle_share = 0.0;
  const Trajectory t =
      Trajectory::Make(robot, RobotPath(), kOrigin, kBegin, {}, 1).value();  // nose to the east
  const Inertial i = MeanInertial(t, robot.ahrs_frd_m, 1.0, 1.01);
  EXPECT_NEAR(i.specific_force_mps2.z(), -NormalGravityNed(kOrigin).z(), 1e-5);
  EXPECT_NEAR(i.specific_force_mps2.head<2>().norm(), 0.0, 1e-6);
  EXPECT_NEAR(i.rate_radps.x(), 0.0, 1e-12);
  EXPECT_NEAR(i.rate_radps.y(), -kEarthRate_radps * std::cos(kOrigin.lat_rad), 1e-12);
  EXPECT_NEAR(i.rate_radps.z(), -kEarthRate_radps * std::sin(kOrigin.lat_rad), 1e-12);
}

/// The simplest strapdown that is good to centimetres in minutes: two-sample coning and sculling
/// terms, navigating in the site's ENU. Source: P. Savage, Strapdown Inertial Navigation
/// Integration Algorithm Design, J. Guidance 21 (1998), parts 1 and 2.
class Strapdown {
 public:
  Strapdown(const Trajectory& trajectory, const Eigen::Vector3d& lever, double start_s)
      : trajectory_(trajectory) {
    const MotionState state = trajectory.AtSeconds(start_s);
    position = state.PointEnu(lever);
    velocity = state.PointVelocityEnu(lever);
    R = state.R_enu_body;
  }

  void Step(const RecordedImu& sample, double dt_s) {
    const Eigen::Vector3d angle = sample.rate_radps * dt_s;
    const Eigen::Vector3d push = sample.specific_force_mps2 * dt_s;
    const Eigen::Vector3d coned = angle + last_angle_.cross(angle) / 12.0;
    const Eigen::Vector3d sculled =
        push + 0.5 * angle.cross(push) + (last_angle_.cross(push) + last_push_.cross(angle)) / 12.0;
    last_angle_ = angle;
    last_push_ = push;

    const core::Geodetic place = plane_.ToGeodetic(position);
    const Eigen::Vector3d gravity =
        trajectory_.RotationNedFromEnu(place).transpose() * NormalGravityNed(place);
    const Eigen::Vector3d earth = kEarthRate_radps * Eigen::Vector3d(0.0, std::cos(kOrigin.lat_rad),
                                                                     std::sin(kOrigin.lat_rad));
    const Eigen::Vector3d change = R * sculled - 0.5 * dt_s * earth.cross(R * push) +
                                   (gravity - 2.0 * earth.cross(velocity)) * dt_s;
    position += (velocity + 0.5 * change) * dt_s;
    velocity += change;
    R = Turn(-earth * dt_s) * R * Turn(coned);
  }

  Eigen::Vector3d position, velocity;
  Eigen::Matrix3d R;

 private:
  static Eigen::Matrix3d Turn(const Eigen::Vector3d& vector) {
    const double angle = vector.norm();
    if (angle < 1e-15) return Eigen::Matrix3d::Identity();
    return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
  }
  const Trajectory& trajectory_;
  const core::LocalEnu plane_{kOrigin};
  Eigen::Vector3d last_angle_ = Eigen::Vector3d::Zero(), last_push_ = Eigen::Vector3d::Zero();
};

class IntegratedBack : public ::testing::TestWithParam<bool> {};

TEST_P(IntegratedBack, IdealInertialDataGiveTheTrajectory) {
  const bool car = GetParam();
  DriveScenario scenario{
      kOrigin, kBegin, {car ? Car() : Robot(), {}}, car ? CarPath() : RobotPath(), 3};
  scenario.path.stand_after_s = 90.0;  // standing costs as much time as driving
  scenario.robot.sensors.imu = ImuConfig::Named("ideal");
  const SimulatedDrive drive =
      SimulateDrive(scenario, {.ground_height_m = Hills, .blocked = {}, .steel = {}}).value();
  const Trajectory& truth = drive.truth.trajectory;
  const Eigen::Vector3d& lever = scenario.robot.vehicle.ahrs_frd_m;
  const auto& imu = drive.recording.imu;
  const auto seconds = [&](std::size_t i) { return core::ToSeconds(imu[i].time - truth.begin()); };
  Strapdown strapdown(truth, lever, seconds(0));
  std::size_t i = 1;
  for (; i < imu.size() && seconds(i) < 120.0; ++i)
    strapdown.Step(imu[i], seconds(i) - seconds(i - 1));
  ASSERT_GT(seconds(i - 1), 119.0);
  const MotionState end = truth.AtSeconds(seconds(i - 1));
  const double position_m = (strapdown.position - end.PointEnu(lever)).norm();
  const double attitude_rad = Eigen::AngleAxisd(end.R_enu_body.transpose() * strapdown.R).angle();
  RecordProperty("position_error_after_120_s_mm", std::to_string(position_m * 1e3));
  RecordProperty("attitude_error_after_120_s_mdeg",
                 std::to_string(attitude_rad * core::kDegFromRad * 1e3));
  std::printf("after 120 s: %.3f mm, %.6f deg\n", position_m * 1e3,
              attitude_rad * core::kDegFromRad);
  EXPECT_LT(position_m, 0.01);
  EXPECT_LT((strapdown.velocity - end.PointVelocityEnu(lever)).norm(), 3e-4);
  EXPECT_LT(attitude_rad, 1e-5);
}
INSTANTIATE_TEST_SUITE_P(RobotAndCar, IntegratedBack, ::testing::Bool());

/// One axis' mean square of the second difference of averages: half of it is the Allan variance.
double AllanVariance(const std::vector<double>& rate, std::size_t per_cluster) {
  std::vector<double> clusters;
  for (std::size_t i = 0; i + per_cluster <= rate.size(); i += per_cluster) {
    double sum = 0.0;
    for (std::size_t k = 0; k < per_cluster; ++k) sum += rate[i + k];
    clusters.push_back(sum / static_cast<double>(per_cluster));
  }
  double sum = 0.0;
  for (std::size_t i = 1; i < clusters.size(); ++i)
    sum += std::pow(clusters[i] - clusters[i - 1], 2);
  return 0.5 * sum / static_cast<double>(clusters.size() - 1);
}

std::vector<Inertial> Noise(const ImuConfig& config, double rate_hz, double hours,
                            const Inertial& truth = {}) {
  ImuErrors errors(config, 77);
  std::vector<Inertial> out;
  for (int i = 0; i < static_cast<int>(hours * 3600.0 * rate_hz); ++i)
    out.push_back(errors.Apply(truth, 1.0 / rate_hz));
  return out;
}
std::vector<double> GyroX(const std::vector<Inertial>& samples) {
  std::vector<double> x;
  for (const Inertial& s : samples) x.push_back(s.rate_radps.x());
  return x;
}

TEST(ImuErrors, WhiteNoiseHasTheRandomWalkOfItsProfile) {
  ImuConfig config;
  config.angle_walk_deg_per_sqrt_h = 2.25;
  config.velocity_walk_mps_per_sqrt_h = 0.1;
  const std::vector<Inertial> samples = Noise(config, 100.0, 0.2);
  // Allan deviation of white noise: random walk / sqrt(tau), here at 1 s.
  const double angle = std::sqrt(AllanVariance(GyroX(samples), 100)) * core::kDegFromRad * 60.0;
  EXPECT_NEAR(angle, 2.25, 0.12);
  std::vector<double> force;
  for (const Inertial& s : samples) force.push_back(s.specific_force_mps2.y());
  EXPECT_NEAR(std::sqrt(AllanVariance(force, 100)) * 60.0, 0.1, 0.006);
}

TEST(ImuErrors, BiasWalkHasItsAllanSlope) {
  ImuConfig config;
  config.gyro_walk_degph_per_sqrt_h = 60.0;
  const std::vector<double> x = GyroX(Noise(config, 1.0, 60.0));
  // Allan variance of a rate random walk: K^2 tau / 3.
  for (const std::size_t tau_s : {100U, 400U}) {
    const double expected_degph = 60.0 * std::sqrt(static_cast<double>(tau_s) / 3600.0 / 3.0);
    const double got_degph = std::sqrt(AllanVariance(x, tau_s)) * core::kDegFromRad * 3600.0;
    EXPECT_NEAR(got_degph / expected_degph, 1.0, 0.15) << tau_s;
  }
}

TEST(ImuErrors, InstabilityIsAGaussMarkovProcessOfItsSizeAndTime) {
  ImuConfig config;
  config.gyro_instability_degph = 20.0;
  config.gyro_instability_tau_s = 100.0;
  const std::vector<double> x = GyroX(Noise(config, 1.0, 30.0));
  double square = 0.0;
  double lagged = 0.0;
  for (std::size_t i = 100; i < x.size(); ++i) {
    square += x[i] * x[i];
    lagged += x[i] * x[i - 100];
  }
  EXPECT_NEAR(std::sqrt(square / static_cast<double>(x.size() - 100)) * core::kDegFromRad * 3600.0,
              20.0, 2.0);
  EXPECT_NEAR(lagged / square, std::exp(-1.0), 0.1);
}

TEST(ImuErrors, DrawnErrorsHaveTheirDeviationsOverManyUnits) {
  const ImuConfig config = ImuConfig::Named("ahrs400cc-100");
  double bias = 0.0;
  double scale = 0.0;
  double misalignment = 0.0;
  constexpr int kUnits = 2000;
  for (int unit = 0; unit < kUnits; ++unit) {
    const ImuErrors errors(config, static_cast<std::uint64_t>(unit));
    bias += errors.accel_bias_mps2().squaredNorm() / 3.0;
    scale += std::pow(errors.gyro_gain()(1, 1) - 1.0, 2);
    misalignment += std::pow(errors.accel_gain()(0, 2), 2);
  }
  // Cut off at two deviations, a normal number keeps 0.88 of its own. Bias at switch-on: what was
  // drawn and the start of the instability together.
  EXPECT_NEAR(std::sqrt(bias / kUnits) / 9.80665e-3,
              std::hypot(0.88 * config.accel_bias_mg, config.accel_instability_mg), 0.12);
  EXPECT_NEAR(std::sqrt(scale / kUnits), 0.88 * config.gyro_scale, 0.0002);
  EXPECT_NEAR(std::sqrt(misalignment / kUnits), 0.88 * config.accel_misalignment, 0.0001);
}

TEST(ImuErrors, ScaleForceSensitivityAndBiasAreWhatIsSaid) {
  ImuConfig config;
  config.gyro_scale = 0.01;
  config.gyro_misalignment = 0.005;
  config.accel_scale = 0.01;
  config.accel_bias_mg = 5.0;
  ImuErrors errors(config, 5);
  const Inertial truth{{0.3, -0.2, 0.1}, {1.0, 2.0, -9.8}};
  const Inertial out = errors.Apply(truth, 0.01);
  EXPECT_LT((out.rate_radps - errors.gyro_gain() * truth.rate_radps).norm(), 1e-12);
  EXPECT_LT((out.specific_force_mps2 - errors.accel_gain() * truth.specific_force_mps2 -
             errors.accel_bias_mps2())
                .norm(),
            1e-12);
  ImuConfig by_force;
  by_force.gyro_g_degps_per_g = 0.1;
  double square = 0.0;
  for (std::uint64_t unit = 0; unit < 500; ++unit) {
    ImuErrors one(by_force, unit);
    square +=
        one.Apply({Eigen::Vector3d::Zero(), {0.0, 0.0, -9.80665}}, 0.01).rate_radps.squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(square / 1500.0) * core::kDegFromRad, 0.088, 0.006);
}

TEST(ImuErrors, RangeLimitsAndCounts) {
  ImuErrors errors(ImuConfig::Named("ideal"), 1);
  const Inertial out = errors.Apply({{4.0, 0.0, -4.0}, {0.0, 0.0, -40.0}}, 0.01);
  EXPECT_NEAR(out.rate_radps.x(), 150.0 * core::kRadFromDeg, 1e-12);
  EXPECT_NEAR(out.rate_radps.z(), -150.0 * core::kRadFromDeg, 1e-12);
  EXPECT_NEAR(out.specific_force_mps2.z(), -3.0 * 9.80665, 1e-12);
  EXPECT_EQ(errors.saturated(), 3U);
}

}  // namespace
}  // namespace kawara::sim
