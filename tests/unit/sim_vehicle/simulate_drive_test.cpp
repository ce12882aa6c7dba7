#include "sim/vehicle/simulate_drive.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <string>

#include "core/config/config.hpp"
#include "tests/unit/sim_vehicle/test_drives.hpp"

namespace kawara::sim {
namespace {

DriveScenario Scenario(std::uint64_t seed) {
  return {kOrigin, kBegin, {Robot(), {}}, RobotPath(), seed};
}
Surroundings Street() {
  Surroundings s;
  s.ground_height_m = Hills;
  s.blocked = [](const Eigen::Vector3d& p, double azimuth, double elevation) {
    return p.x() > 8.0 && std::cos(azimuth) > 0.3 && elevation < 1.2;  // a house to the north
  };
  s.steel = {{{10, 2, 0}, {0, 0, -120}}};
  return s;
}

template <class T>
void Put(std::string& bytes, const T& value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

/// Everything that was measured, as bytes.
std::string Bytes(const SimulatedDrive& d) {
  std::string bytes;
  for (const RecordedFix& f : d.recording.fixes) {
    Put(bytes, f.time.ns());
    Put(bytes, f.antenna.lat_rad);
    Put(bytes, f.antenna.lon_rad);
    Put(bytes, f.antenna.h_ellipsoidal_m);
    Put(bytes, f.rtk);
    Put(bytes, f.satellites);
    for (const double v : f.velocity_ned_mps) Put(bytes, v);
    for (const double v : f.sd_ned_m) Put(bytes, v);
  }
  for (const RecordedImu& s : d.recording.imu) {
    Put(bytes, s.time.ns());
    for (const double v : s.rate_radps) Put(bytes, v);
    for (const double v : s.specific_force_mps2) Put(bytes, v);
    for (const double v : *s.magnetic_gauss) Put(bytes, v);
  }
  for (const OdometrySample& s : d.truth.odometry) {
    Put(bytes, s.stamp.ns());
    Put(bytes, s.left_ticks);
    Put(bytes, s.right_ticks);
  }
  return bytes;
}

TEST(SimulateDrive, SameSeedSameBytesOtherSeedOtherErrors) {
  const std::string once = Bytes(SimulateDrive(Scenario(7), Street()).value());
  const std::string again = Bytes(SimulateDrive(Scenario(7), Street()).value());
  const std::string other = Bytes(SimulateDrive(Scenario(8), Street()).value());
  ASSERT_GT(once.size(), 100'000U);
  EXPECT_TRUE(once == again);
  EXPECT_FALSE(once == other);
}

TEST(SimulateDrive, OneSensorsSettingsLeaveTheOthersDiceAlone) {
  DriveScenario changed = Scenario(7);
  changed.robot.sensors.imu = ImuConfig::Named("ideal");
  changed.robot.sensors.magnetometer.noise_gauss = 0.0;
  const SimulatedDrive a = SimulateDrive(Scenario(7)).value();
  const SimulatedDrive b = SimulateDrive(changed).value();
  ASSERT_EQ(a.recording.fixes.size(), b.recording.fixes.size());
  for (std::size_t i = 0; i < a.recording.fixes.size(); ++i)
    ASSERT_EQ(a.recording.fixes[i].antenna.lat_rad, b.recording.fixes[i].antenna.lat_rad);
  ASSERT_EQ(a.truth.odometry.back().left_ticks, b.truth.odometry.back().left_ticks);
}

TEST(SimulateDrive, RecordingIsOneThatTheInstrumentsTake) {
  const SimulatedDrive d = SimulateDrive(Scenario(1), Street()).value();
  const Recording& r = d.recording;
  EXPECT_EQ(r.fixes.front().time, kBegin);
  EXPECT_LT(r.begin(), r.end());
  for (std::size_t i = 1; i < r.fixes.size(); ++i)
    ASSERT_EQ(r.fixes[i].time - r.fixes[i - 1].time, core::Milliseconds(100));
  for (std::size_t i = 1; i < r.imu.size(); ++i) {
    ASSERT_GT(r.imu[i].time, r.imu[i - 1].time);
    ASSERT_TRUE(r.imu[i].magnetic_gauss);
  }
  EXPECT_NEAR(r.site.imu_late_s, 0.006 + 0.005, 1e-12);
}

TEST(SimulateDrive, FixesAreTruthPlusTheErrorTold) {
  const SimulatedDrive d = SimulateDrive(Scenario(1), Street()).value();
  const VehicleConfig robot = Robot();
  ASSERT_EQ(d.truth.epochs.size(), d.recording.fixes.size());
  for (std::size_t i = 0; i < d.truth.epochs.size(); i += 7) {
    const GnssEpochTruth& truth = d.truth.epochs[i];
    const RecordedFix& fix = d.recording.fixes[i];
    ASSERT_LT((core::NedBetween(truth.antenna, fix.antenna) - truth.error_ned_m).norm(), 1e-6);
    const core::Geodetic antenna = d.truth.trajectory.GeodeticAt(fix.time, robot.antenna_frd_m);
    ASSERT_LT(core::NedBetween(truth.antenna, antenna).norm(), 1e-6);
  }
}

TEST(SimulateDrive, SampleRateIsTheUnitsOwn) {
  DriveScenario scenario = Scenario(1);
  scenario.robot.sensors.imu.clock.skew_ppm = 400.0;
  const Recording r = SimulateDrive(scenario).value().recording;
  const double period_s = core::ToSeconds(r.imu.back().time - r.imu.front().time) /
                          static_cast<double>(r.imu.size() - 1);
  EXPECT_NEAR(period_s / 0.01, 1.0 - 400e-6, 1e-6) << "a fast crystal makes short periods";
}

TEST(RobotModel, ProfileGivesTheFiguresAndKeysReplaceThem) {
  const auto model = config::Parse<SensorsConfig>(
      "imu: {profile: typical-mems, accel_bias_mg: 7}\n"
      "gnss: {profile: ideal, events: [{kind: wrong-fix, t_s: 30, length_s: 8}]}\n",
      "test");
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_EQ(model->imu.angle_walk_deg_per_sqrt_h, 0.8);
  EXPECT_EQ(model->imu.accel_bias_mg, 7.0);
  EXPECT_EQ(model->gnss.fixed.wander_m, 0.0);
  ASSERT_EQ(model->gnss.events.size(), 1U);
  EXPECT_EQ(model->gnss.events[0].kind, GnssEventKind::kWrongFix);
  EXPECT_EQ(model->odometry.profile, "skid-steer") << "left out: the usual one";
  const auto again = config::Parse<SensorsConfig>(config::Dump(*model), "dumped");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(config::Dump(*again), config::Dump(*model));
}

TEST(RobotModel, MistakesAreToldWithTheirPlaces) {
  const auto model = config::Parse<RobotModel>(
      "vehicle: {kind: hovercraft, wheelbase_m: 0.5, track_m: 0.4, antenna_frd_m: [0, 0, -1],\n"
      "  ahrs_frd_m: [0, 0, 0], camera_frd_m: [0, 0, -1]}\n"
      "sensors: {imu: {profile: perfect}}\n",
      "x.yaml");
  ASSERT_FALSE(model);
  EXPECT_NE(model.error().message.find("x.yaml:1:"), std::string::npos) << model.error().message;
  EXPECT_NE(model.error().message.find("skid-steer"), std::string::npos);
  EXPECT_NE(model.error().message.find("x.yaml:3:"), std::string::npos);
}

TEST(RobotModel, CommittedVehiclesDrive) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(
           std::filesystem::path(KAWARA_SOURCE_DIR) / "configs/vehicles")) {
    const auto model = config::Load<RobotModel>(entry.path().string());
    ASSERT_TRUE(model) << model.error().message;
    PathConfig path;
    path.waypoints = {{0, 0, {}, 0}, {40, 0, {}, 0}, {40, 40, {}, 0}};
    const auto drive = SimulateDrive({kOrigin, kBegin, *model, path, 1});
    ASSERT_TRUE(drive) << drive.error().message;
    EXPECT_GT(drive->recording.imu.size(), 1000U);
    ++count;
  }
  EXPECT_GE(count, 2);
}

}  // namespace
}  // namespace kawara::sim
