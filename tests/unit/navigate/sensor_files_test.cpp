#include "tools/navigate/sensor_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/navigate/test_files.hpp"
#include "tools/navigate/decimal_time.hpp"

namespace kawara::navigate {
namespace {

using ::testing::HasSubstr;

constexpr double kDeg = core::kRadFromDeg;

class SensorFiles : public WithFiles {};

TEST_F(SensorFiles, GnssRowBecomesAFix) {
  const auto file =
      ReadGnss(File("t,lat,lon,h,sdN,sdE,sdD,q,nsat,vN,vE,vD,sdvN,sdvE,sdvD,t_rx\n"
                    "100.1,38.5,140.25,62.5,0.01,0.02,0.03,1,17,1,2,3,0.1,0.2,0.3,100.25\n"),
               true);
  ASSERT_TRUE(file) << file.error().message;
  const core::GnssFix& fix = file->rows.at(0).fix;
  EXPECT_EQ(fix.time, *ParseSeconds("100.1"));
  EXPECT_EQ(file->rows[0].received, *ParseSeconds("100.25"));
  EXPECT_DOUBLE_EQ(fix.antenna.lat_rad, 38.5 * kDeg);
  EXPECT_DOUBLE_EQ(fix.antenna.lon_rad, 140.25 * kDeg);
  EXPECT_EQ(fix.antenna.h_ellipsoidal_m, 62.5);
  EXPECT_EQ(fix.rtk, core::RtkState::kFixed);
  EXPECT_EQ(fix.satellites, 17);
  EXPECT_TRUE(fix.has_position && fix.has_velocity && fix.covariance_from_receiver);
  EXPECT_TRUE(fix.velocity_enu_mps.isApprox(Eigen::Vector3d(2.0, 1.0, -3.0)));
  EXPECT_TRUE(fix.velocity_sd_enu_mps.isApprox(Eigen::Vector3d(0.2, 0.1, 0.3)));
  EXPECT_TRUE(fix.position_cov_enu_m2.isApprox(
      Eigen::Vector3d(4e-4, 1e-4, 9e-4).asDiagonal().toDenseMatrix()));
  EXPECT_FALSE(file->rows[0].heading);
}

TEST_F(SensorFiles, QualityIsTheStateAndGivesDeviationsWhereNoneAreStated) {
  struct Case {
    int q;
    core::RtkState state;
    double sd_m;
  };
  for (const Case& c : {Case{1, core::RtkState::kFixed, 0.02}, Case{2, core::RtkState::kFloat, 0.4},
                        Case{3, core::RtkState::kCodeDifferential, 1.0},
                        Case{4, core::RtkState::kCodeDifferential, 1.0},
                        Case{5, core::RtkState::kAutonomous, 3.0}}) {
    const auto file = ReadGnss(File("t,lat,lon,h,q\n1,2,3,4," + std::to_string(c.q) + "\n"), false);
    ASSERT_TRUE(file) << file.error().message;
    const core::GnssFix& fix = file->rows.at(0).fix;
    EXPECT_EQ(fix.rtk, c.state);
    EXPECT_DOUBLE_EQ(fix.position_cov_enu_m2(0, 0), c.sd_m * c.sd_m);
    EXPECT_FALSE(fix.covariance_from_receiver || fix.has_velocity);
    EXPECT_EQ(file->rows[0].received, fix.time);
  }
}

TEST_F(SensorFiles, EpochWithoutSolutionIsNoMistakeAndNoPosition) {
  const auto file = ReadGnss(File("t,lat,lon,h,q\n1,2,3,4,1\n2,,,,0\n3,nan,nan,nan,0\n"), false);
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_EQ(file->rows.size(), 3U);
  EXPECT_FALSE(file->rows[1].fix.has_position || file->rows[2].fix.has_position);
  EXPECT_EQ(file->report.bad_rows, 0);
}

TEST_F(SensorFiles, HalfAVelocityIsNone) {
  const auto file = ReadGnss(File("t,lat,lon,h,q,vN,vE,vD\n1,2,3,4,1,1,nan,0\n"), false);
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_TRUE(file->rows.at(0).fix.has_position);
  EXPECT_FALSE(file->rows[0].fix.has_velocity);
}

TEST_F(SensorFiles, SecondAntennaIsAHeadingMeasurement) {
  const auto file = ReadGnss(
      File("t,lat,lon,h,q,heading,sd_heading\n1,2,3,4,1,270,0.25\n2,2,3,4,1,nan,nan\n"), false);
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_TRUE(file->rows.at(0).heading);
  EXPECT_TRUE(file->rows[0].heading->has_heading);
  EXPECT_FALSE(file->rows[0].heading->has_level);
  EXPECT_NEAR(file->rows[0].heading->attitude.yaw_rad, -90.0 * kDeg, 1e-12);
  EXPECT_DOUBLE_EQ(file->rows[0].heading->heading_sd_rad, 0.25 * kDeg);
  EXPECT_FALSE(file->rows.at(1).heading);
}

TEST_F(SensorFiles, GnssRowsThatCannotBe) {
  for (const char* row : {"5,91,3,4,1", "5,2,361,4,1", "5,2,3,2e5,1", "5,2,3,4,7", "5,2,3,4,1.5",
                          "5,2,3,4,-1", "5,nan,3,4,1"}) {
    const auto file =
        ReadGnss(File("t,lat,lon,h,q\n1,2,3,4,1\n2,2,3,4,1\n" + std::string(row) + "\n"), false);
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(file->report.bad_rows, 1) << row;
    EXPECT_EQ(file->rows.size(), 2U) << row;
  }
}

TEST_F(SensorFiles, ArrivalTimesMustBeThereIfNeeded) {
  const std::string path = File("t,lat,lon,h,q\n1,2,3,4,1\n");
  EXPECT_TRUE(ReadGnss(path, false));
  EXPECT_THAT(ReadGnss(path, true).error().message,
              HasSubstr("file.csv:1: no column 't_rx', which --use-arrival-times needs"));
}

TEST_F(SensorFiles, OdometryWithAndWithoutTurnRate) {
  const auto with = ReadOdometry(File("t,vx,wz\n1,0.5,0.1\n2,0.5,nan\n"));
  ASSERT_TRUE(with) << with.error().message;
  EXPECT_TRUE(with->rows.at(0).has_turn_rate);
  EXPECT_EQ(with->rows[0].turn_rate_radps, 0.1);
  EXPECT_FALSE(with->rows.at(1).has_turn_rate);
  const auto without = ReadOdometry(File("t,vx\n1,0.5\n"));
  ASSERT_TRUE(without) << without.error().message;
  EXPECT_EQ(without->rows.at(0).speed_mps, 0.5);
  EXPECT_FALSE(without->rows[0].has_turn_rate);
}

TEST_F(SensorFiles, AttitudeInDegrees) {
  const auto file = ReadAttitude(File("t,roll,pitch,yaw\n1,10,-20,300\n"));
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_TRUE(file->rows.at(0).has_level && file->rows[0].has_heading);
  EXPECT_DOUBLE_EQ(file->rows[0].attitude.roll_rad, 10.0 * kDeg);
  EXPECT_DOUBLE_EQ(file->rows[0].attitude.pitch_rad, -20.0 * kDeg);
  EXPECT_EQ(file->rows[0].heading_sd_rad, 0.0);
  const auto level = ReadAttitude(File("t,roll,pitch\n1,10,-20\n"));
  ASSERT_TRUE(level) << level.error().message;
  EXPECT_FALSE(level->rows.at(0).has_heading);
}

TEST_F(SensorFiles, WindowsOfOneRun) {
  const std::string runs = "run,length_s,t_start,t_end\n1,10,100,110\n2,15,50,65\n2,15,20,35\n";
  const auto second = ReadWindows(File(runs), 2);
  ASSERT_TRUE(second) << second.error().message;
  ASSERT_EQ(second->rows.size(), 2U);
  EXPECT_EQ(second->rows[0].begin, *ParseSeconds("20"));
  EXPECT_THAT(ReadWindows(File(runs), {}).error().message,
              HasSubstr("choose one with --blank-run"));
  EXPECT_THAT(ReadWindows(File(runs), 7).error().message, HasSubstr("no window of run 7"));
  EXPECT_THAT(ReadWindows(File("t_start,t_end\n1,2\n"), 1).error().message,
              HasSubstr("no column 'run'"));
}

TEST_F(SensorFiles, WindowsNeedNoHeaderAndEndLater) {
  const auto file = ReadWindows(File("10,20\n30,30\n40,45\n"), {});
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->rows.size(), 2U);
  EXPECT_EQ(file->report.bad_rows, 1);
}

TEST_F(SensorFiles, AWindowHoldsItsBeginAndNotItsEnd) {
  const TimeWindow window{*ParseSeconds("10"), *ParseSeconds("20")};
  EXPECT_TRUE(window.Contains(*ParseSeconds("10")));
  EXPECT_TRUE(window.Contains(*ParseSeconds("19.999")));
  EXPECT_FALSE(window.Contains(*ParseSeconds("20")));
}

TEST_F(SensorFiles, ImuOfTheRecordedDrive) {
  auto imu = ImuFile::Open(std::string(KAWARA_SOURCE_DIR) + "/data/drive_0708/imu.csv.gz");
  ASSERT_TRUE(imu) << imu.error().message;
  auto sample = imu->Next();
  ASSERT_TRUE(sample && *sample);
  EXPECT_EQ(FormatSeconds((*sample)->time), "243261.729");
  EXPECT_EQ((*sample)->rate_radps, Eigen::Vector3d(0.005013, 0.017023, -0.002356));
  EXPECT_EQ((*sample)->specific_force_mps2, Eigen::Vector3d(-0.01076, 0.19662, -9.72906));
  int count = 1;
  while (imu->Next()->has_value()) ++count;
  EXPECT_EQ(count, 54858);
}

}  // namespace
}  // namespace kawara::navigate
