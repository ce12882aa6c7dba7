#include "sim/evaluate/pose_errors.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace kawara::sim {
namespace {

using ::testing::HasSubstr;

const core::Geodetic kPlace{0.62, 2.43, 50.0};

/// Drives north at 1 m/s, turning through north (yaw about 0) by 10 deg/s.
TablePose TruthAt(double t_s) {
  TablePose pose;
  pose.time = core::GpsTime::FromNs(1'400'000'000'000'000'000) + core::DurationFromSeconds(t_s);
  pose.position = core::OffsetNed(kPlace, {t_s, 0, 0});
  pose.attitude = core::Attitude{0.01, -0.02, core::WrapPi((t_s - 5.0) * 10 * core::kRadFromDeg)};
  return pose;
}

std::vector<TablePose> Truth() {
  std::vector<TablePose> truth;
  for (int i = 0; i <= 100; ++i) truth.push_back(TruthAt(i * 0.1));
  return truth;
}

/// The number after "name" and its `column`-th following figure in the JSON.
double Figure(const ErrorReport& report, const std::string& name, const std::string& key) {
  const std::string json = report.Json();
  const auto row = json.find("\"" + name + "\": {");
  EXPECT_NE(row, std::string::npos) << name;
  const auto at = json.find("\"" + key + "\": ", row);
  return std::stod(json.substr(at + key.size() + 4));
}

TEST(ComparePoses, TheTruthItselfHasNoError) {
  const auto report = ComparePoses(Truth(), Truth());
  ASSERT_TRUE(report);
  EXPECT_LT(Figure(*report, "3D", "max"), 1e-6);
  EXPECT_LT(Figure(*report, "yaw", "max"), 1e-9);
}

TEST(ComparePoses, ErrorsComeOutInTheirAxes) {
  auto result = Truth();
  for (TablePose& pose : result) {
    pose.position = core::OffsetNed(pose.position, {0.3, -0.4, 0.1});  // north, east, down
    pose.attitude->yaw_rad = core::WrapPi(pose.attitude->yaw_rad + 2 * core::kRadFromDeg);
  }
  const auto report = ComparePoses(Truth(), result);
  ASSERT_TRUE(report);
  EXPECT_NEAR(Figure(*report, "north", "mean"), 0.3, 1e-6);
  EXPECT_NEAR(Figure(*report, "east", "mean"), -0.4, 1e-6);
  EXPECT_NEAR(Figure(*report, "up", "mean"), -0.1, 1e-6);
  EXPECT_NEAR(Figure(*report, "horizontal", "rms"), 0.5, 1e-6);
  EXPECT_NEAR(Figure(*report, "yaw", "mean"), 2.0, 1e-9) << "also where it passes north";
}

TEST(ComparePoses, TruthIsInterpolatedButNotAcrossGaps) {
  auto truth = Truth();
  truth.erase(truth.begin() + 40, truth.begin() + 60);  // 2 s
  const auto report = ComparePoses(truth, {TruthAt(1.234), TruthAt(5.0), TruthAt(11.0)});
  ASSERT_TRUE(report);
  EXPECT_LT(Figure(*report, "3D", "max"), 1e-4);
  EXPECT_EQ(Figure(*report, "3D", "n"), 1);
  EXPECT_EQ(Figure(*report, "poses outside the truth", "value"), 2);
}

TEST(ComparePoses, ClaimsAreHeldAgainstErrors) {
  auto result = Truth();
  for (TablePose& pose : result) {
    pose.position = core::OffsetNed(pose.position, {0.03, 0.04, 0});
    pose.sd_enu_m = {0.02, 0.015, 0.05};  // twice too small in each axis
  }
  const auto report = ComparePoses(Truth(), result);
  ASSERT_TRUE(report);
  EXPECT_NEAR(Figure(*report, "squared horizontal error / claimed variance", "mean"), 4.0, 1e-3);
}

TEST(ComparePoses, AnotherDriveIsRefused) {
  auto later = Truth();
  for (TablePose& pose : later) pose.time = pose.time + core::Seconds(1000);
  EXPECT_FALSE(ComparePoses(Truth(), later));
}

TEST(ReadPoses, ReadsPlainAndExportedColumnsAndSaysWhatIsMissing) {
  const auto folder = std::filesystem::temp_directory_path() / "kawara_pose_errors_test";
  std::filesystem::create_directories(folder);
  const auto write = [&](const char* name, const char* text) {
    std::ofstream(folder / name) << text;
    return (folder / name).string();
  };
  const auto plain = ReadPoses(write("plain.csv",
                                     "gps_ns,lat_deg,lon_deg,h_m,q\n"
                                     "1436038567999464985,40.5,-105.25,1601,1\n"
                                     "1436038566999464985,40.5,-105.25,1600,2\n"
                                     "1436038568999464985,,,,1\n"));
  ASSERT_TRUE(plain) << plain.error().message;
  ASSERT_EQ(plain->size(), 2U) << "one has no place";
  EXPECT_EQ((*plain)[0].time.ns(), 1436038566999464985) << "in order of time, to the nanosecond";
  EXPECT_DOUBLE_EQ((*plain)[0].position.lat_rad, 40.5 * core::kRadFromDeg);
  EXPECT_FALSE((*plain)[0].attitude);
  const auto exported = ReadPoses(write(
      "exported.csv",
      "robot,pose.gps_ns,pose.lat_deg,pose.lon_deg,pose.h_ellipsoidal_m,pose.roll_deg,"
      "pose.pitch_deg,pose.yaw_deg,pose.position_cov_enu_m2[0],pose.position_cov_enu_m2[4],"
      "pose.position_cov_enu_m2[8]\nr,1436038567999464985,40,-105,1601,1,2,90,0.0004,0.0009,1\n"));
  ASSERT_TRUE(exported) << exported.error().message;
  EXPECT_NEAR((*exported)[0].attitude->yaw_rad, core::kPi / 2, 1e-12);
  EXPECT_NEAR((*exported)[0].sd_enu_m.y(), 0.03, 1e-9);
  const auto wrong = ReadPoses(write("wrong.csv", "gps_ns,latitude\n1,2\n"));
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message,
              HasSubstr("no column lat_deg, pose.lat_deg; there are gps_ns, latitude"));
  EXPECT_FALSE(ReadPoses((folder / "none.csv").string()));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace kawara::sim
