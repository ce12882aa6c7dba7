#include "sim/vehicle/drive_truth_csv.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/unit/sim_vehicle/test_drives.hpp"

namespace kawara::sim {
namespace {

std::vector<std::vector<std::string>> ReadCsv(const std::filesystem::path& file) {
  std::vector<std::vector<std::string>> rows;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    auto& row = rows.emplace_back();
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell);
  }
  return rows;
}

TEST(DriveTruthCsv, EveryTableHasItsRowsAndTheTrajectoryReadsBack) {
  std::string folder = testing::TempDir() + "kawara_truth_XXXXXX";
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  const SimulatedDrive drive =
      SimulateDrive({kOrigin, kBegin, {Robot(), {}}, RobotPath(), 1}).value();
  ASSERT_TRUE(WriteDriveTruth(drive.truth, folder + "/deep/er", 10.0));
  const std::filesystem::path out = folder + "/deep/er";
  for (const char* name :
       {"truth_trajectory.csv", "truth_gnss.csv", "truth_odometry.csv", "truth_imu_bias.csv"}) {
    const auto rows = ReadCsv(out / name);
    ASSERT_GT(rows.size(), 30U) << name;
    for (const auto& row : rows) ASSERT_EQ(row.size(), rows[0].size()) << name;
  }
  EXPECT_EQ(ReadCsv(out / "truth_gnss.csv").size(), drive.truth.epochs.size() + 1);
  EXPECT_EQ(ReadCsv(out / "truth_odometry.csv").size(), drive.truth.odometry.size() + 1);
  const auto rows = ReadCsv(out / "truth_trajectory.csv");
  const auto& row = rows[400];
  const core::GpsTime t = core::GpsTime::FromNs(std::stoll(row[0]));
  const core::Geodetic place{std::stod(row[1]) * core::kRadFromDeg,
                             std::stod(row[2]) * core::kRadFromDeg, std::stod(row[3])};
  const core::Geodetic truth = drive.truth.trajectory.GeodeticAt(t, Eigen::Vector3d::Zero());
  EXPECT_LT(core::NedBetween(truth, place).norm(), 1e-5);
  EXPECT_NEAR(std::stod(row[6]) * core::kRadFromDeg, drive.truth.trajectory.AttitudeAt(t).yaw_rad,
              1e-8);
  std::filesystem::remove_all(folder);
}

TEST(DriveTruthCsv, WhereItCannotWriteItSaysSo) {
  const SimulatedDrive drive =
      SimulateDrive({kOrigin, kBegin, {Robot(), {}}, RobotPath(), 1}).value();
  const auto written = WriteDriveTruth(drive.truth, "/proc/nowhere");
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().message.find("/proc/nowhere"), std::string::npos);
}

}  // namespace
}  // namespace kawara::sim
