#include "sim/vehicle/magnetometer.hpp"

#include <gtest/gtest.h>

#include "tests/unit/sim_vehicle/test_drives.hpp"

namespace kawara::sim {
namespace {

TEST(Magnetometer, DipoleFieldOnAxisAndBesideIt) {
  const std::vector<SteelObject> steel{{{0, 0, 0}, {0, 0, -100.0}}};
  // B = mu0 m / (2 pi r^3) on the axis, half of it and opposed beside; 1 T = 1e4 gauss.
  EXPECT_NEAR(SteelFieldEnu(steel, {0, 0, 2.0}).z(), -2e-7 * 100.0 / 8.0 * 1e4, 1e-12);
  EXPECT_NEAR(SteelFieldEnu(steel, {2.0, 0, 0}).z(), 1e-7 * 100.0 / 8.0 * 1e4, 1e-12);
  EXPECT_LT(SteelFieldEnu(steel, {30.0, 0, 0}).norm(), 1e-5);
  EXPECT_TRUE(SteelFieldEnu(steel, {0, 0, 0}).allFinite());
}

TEST(Magnetometer, IdealShowsMagneticHeading) {
  MagnetometerConfig config;
  const std::vector<SteelObject> none;
  Magnetometer ideal(config, none, 1);
  PathConfig path;
  path.waypoints = {{0, 0, {}, 0}, {10, 10, {}, 0}};  // true heading 45 degrees
  VehicleConfig robot = Robot();
  robot.vibration.idle_share = 0.0;
  const Trajectory t = Trajectory::Make(robot, path, kOrigin, kBegin, {}, 1).value();
  const Eigen::Vector3d b = ideal.Measure(t.AtSeconds(0.0), robot.ahrs_frd_m);
  EXPECT_NEAR(b.norm(), config.field_gauss, 1e-12);
  EXPECT_NEAR(std::atan2(-b.y(), b.x()) * core::kDegFromRad, 45.0 - config.declination_deg, 1e-9);
  EXPECT_NEAR(std::asin(b.z() / b.norm()) * core::kDegFromRad, config.dip_deg, 1e-9);
}

TEST(Magnetometer, ACarBesideTheWayTurnsTheCompassByDegrees) {
  const std::vector<SteelObject> steel{{{0.0, 1.5, 0.5}, {60.0, 60.0, -100.0}}};
  MagnetometerConfig config;
  Magnetometer near(config, steel, 1);
  const std::vector<SteelObject> none;
  Magnetometer far(config, none, 1);
  MotionState state;  // at the origin; any attitude will do
  const Eigen::Vector3d a = near.Measure(state, Eigen::Vector3d::Zero());
  const Eigen::Vector3d b = far.Measure(state, Eigen::Vector3d::Zero());
  const double turned = std::acos(a.normalized().dot(b.normalized())) * core::kDegFromRad;
  EXPECT_GT(turned, 2.0);
  EXPECT_LT(turned, 60.0);
}

TEST(Magnetometer, NoiseAndIronHaveTheirSizes) {
  const MagnetometerConfig config = MagnetometerConfig::Named("on-robot");
  const std::vector<SteelObject> none;
  const MotionState state;
  Magnetometer one(config, none, 9);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d square = Eigen::Vector3d::Zero();
  constexpr int kSamples = 4000;
  for (int i = 0; i < kSamples; ++i) {
    const Eigen::Vector3d b = one.Measure(state, Eigen::Vector3d::Zero());
    mean += b / kSamples;
    square += b.cwiseAbs2() / kSamples;
  }
  const Eigen::Vector3d variance = square - mean.cwiseAbs2();
  for (const double axis : variance) EXPECT_NEAR(std::sqrt(axis), config.noise_gauss, 2e-4);
  MagnetometerConfig hard;
  hard.hard_iron_gauss = 0.01;
  Magnetometer ideal({}, none, 0);
  const Eigen::Vector3d earth = ideal.Measure(state, Eigen::Vector3d::Zero());
  double sum = 0.0;
  for (std::uint64_t seed = 0; seed < 300; ++seed)
    sum += (Magnetometer(hard, none, seed).Measure(state, Eigen::Vector3d::Zero()) - earth)
               .squaredNorm();
  EXPECT_NEAR(std::sqrt(sum / 900.0), 0.0088, 0.0007);
}

}  // namespace
}  // namespace kawara::sim
