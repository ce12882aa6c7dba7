// PoseComposer on the recorded minute of data/estimation, against its exact truth.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "estimation/pose_composer.hpp"

namespace kawara::estimation {
namespace {

using core::DurationFromSeconds;
using core::GpsTime;
using core::kRadFromDeg;
using core::MonoTime;

struct Row {
  std::vector<double> v;
};
std::vector<Row> Load(const std::string& name) {
  std::ifstream file(KAWARA_SOURCE_DIR "/data/estimation/" + name);
  std::vector<Row> rows;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    Row row;
    std::istringstream fields(line);
    std::string field;
    while (std::getline(fields, field, ',')) row.v.push_back(std::stod(field));
    rows.push_back(row);
  }
  return rows;
}

struct Replay {
  std::vector<core::Pose> poses;  ///< at every truth epoch, asked when the AHRS is there
  std::vector<Row> truth;
};

/// 60 s of the synthetic robot as its instruments sent it, in the order of arrival.
Replay RunRecorded() {
  const auto gnss = Load("drive_gnss.csv"), ahrs = Load("drive_ahrs.csv"),
             imu = Load("drive_imu.csv");
  Replay out;
  out.truth = Load("drive_truth.csv");
  const GpsTime week = core::FromWeek({2300, {}});
  const auto gps = [&](double t) { return week + DurationFromSeconds(t); };
  const auto mono = [&](double t) {
    return MonoTime::FromNs(0) + DurationFromSeconds(t - 300000.0);
  };
  GpsTimelineConfig clock_config;
  clock_config.envelope.min_latency_s = 0.085;
  GpsTimeline clock(clock_config);
  PoseComposerConfig config;
  config.lever_arm_frd_m << 0.12, -0.18, -0.92;
  PoseComposer composer(config);
  std::size_t g = 0, w = 0, k = 0;
  out.poses.reserve(out.truth.size());
  for (const Row& a : ahrs) {
    for (; g < gnss.size() && gnss[g].v[15] <= a.v[0]; ++g) {
      const auto& f = gnss[g].v;
      core::GnssFix fix;
      fix.time = gps(f[0]);
      fix.arrival = mono(f[15]);
      fix.rtk = f[7] == 1.0 ? core::RtkState::kFixed : core::RtkState::kFloat;
      fix.has_position = true;
      fix.antenna = {f[1] * kRadFromDeg, f[2] * kRadFromDeg, f[3]};
      fix.position_cov_enu_m2 = Eigen::Vector3d(f[5] * f[5], f[4] * f[4], f[6] * f[6]).asDiagonal();
      fix.has_velocity = true;
      fix.velocity_enu_mps << f[10], f[9], -f[11];
      fix.velocity_sd_enu_mps << f[13], f[12], f[14];
      clock.AddEpoch(fix.time, fix.arrival);
      composer.AddFix(fix, clock);
    }
    while (w + 1 < imu.size() && imu[w].v[0] < a.v[0]) ++w;
    core::AhrsSample sample;
    sample.sampled = mono(a.v[0]);
    sample.has_attitude = true;
    sample.attitude = {a.v[1] * kRadFromDeg, a.v[2] * kRadFromDeg, a.v[3] * kRadFromDeg};
    sample.rate_radps << imu[w].v[1], imu[w].v[2], imu[w].v[3];
    composer.AddAhrs(sample);
    // The epoch is asked for 0.3 s after it, as a picture is.
    for (; k < out.truth.size() && out.truth[k].v[0] + 0.3 < a.v[0]; ++k) {
      out.poses.push_back(composer.At(mono(out.truth[k].v[0]), clock));
    }
  }
  return out;
}

TEST(PoseComposerRecorded, ErrorsAreThoseOfTheInstrumentsAndTheCovarianceKnowsThem) {
  const Replay run = RunRecorded();
  ASSERT_GT(run.poses.size(), 400u);
  double horizontal2 = 0, vertical2 = 0, tilt2 = 0, yaw2 = 0, nees = 0;
  int n = 0;
  for (std::size_t i = 0; i < run.poses.size(); ++i) {
    const auto& t = run.truth[i].v;
    if (t[0] < 300090.0) continue;  // clock and heading settle
    const core::Pose& pose = run.poses[i];
    ASSERT_TRUE(pose.valid);
    const Eigen::Vector3d ned =
        core::NedBetween({t[1] * kRadFromDeg, t[2] * kRadFromDeg, t[3]}, pose.position);
    const Eigen::Vector3d enu(ned.y(), ned.x(), -ned.z());
    horizontal2 += ned.head<2>().squaredNorm();
    vertical2 += ned.z() * ned.z();
    nees += enu.dot(pose.position_cov_enu_m2.inverse() * enu);
    tilt2 += std::pow(pose.attitude.roll_rad - t[7] * kRadFromDeg, 2) +
             std::pow(pose.attitude.pitch_rad - t[8] * kRadFromDeg, 2);
    yaw2 += std::pow(core::WrapPi(pose.attitude.yaw_rad - t[9] * kRadFromDeg), 2);
    ++n;
  }
  const double horizontal_m = std::sqrt(horizontal2 / n), vertical_m = std::sqrt(vertical2 / n);
  const double tilt_deg = std::sqrt(tilt2 / 2 / n) / kRadFromDeg,
               yaw_deg = std::sqrt(yaw2 / n) / kRadFromDeg;
  RecordProperty("horizontal_mm", std::to_string(1e3 * horizontal_m));
  RecordProperty("vertical_mm", std::to_string(1e3 * vertical_m));
  RecordProperty("tilt_deg", std::to_string(tilt_deg));
  RecordProperty("yaw_deg", std::to_string(yaw_deg));
  RecordProperty("nees_position", std::to_string(nees / n));
  EXPECT_LT(horizontal_m, 0.04);
  EXPECT_LT(vertical_m, 0.05);
  EXPECT_LT(tilt_deg, 2.0);
  EXPECT_LT(yaw_deg, 4.0);
  EXPECT_GT(nees / n, 0.3);
  EXPECT_LT(nees / n, 6.0);
}

TEST(PoseComposerRecorded, SameInputSameBytes) {
  const Replay a = RunRecorded(), b = RunRecorded();
  ASSERT_EQ(a.poses.size(), b.poses.size());
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    EXPECT_EQ(std::memcmp(&a.poses[i].position, &b.poses[i].position, sizeof(core::Geodetic)), 0);
    EXPECT_EQ(std::memcmp(&a.poses[i].attitude, &b.poses[i].attitude, sizeof(core::Attitude)), 0);
    EXPECT_EQ(std::memcmp(a.poses[i].position_cov_enu_m2.data(),
                          b.poses[i].position_cov_enu_m2.data(), 72),
              0);
  }
}

}  // namespace
}  // namespace kawara::estimation
