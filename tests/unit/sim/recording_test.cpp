#include "sim/motion/recording.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>

#include "sim/motion/motion_track.hpp"

namespace kawara::sim {
namespace {

const std::filesystem::path kDrive = std::filesystem::path(KAWARA_SOURCE_DIR) / "data/drive_0708";

TEST(Recording, TheDriveIsWhole) {
  const auto drive = LoadRecording(kDrive);
  ASSERT_TRUE(drive) << drive.error().message;
  EXPECT_EQ(drive->fixes.size(), 2197U);
  EXPECT_EQ(drive->imu.size(), 54858U);
  EXPECT_EQ(std::count_if(drive->fixes.begin(), drive->fixes.end(),
                          [](const RecordedFix& f) { return f.rtk == core::RtkState::kFloat; }),
            8);
  // 2025-07-08 19:34:18.499 GPS = 19:34:00.499 UTC.
  const core::CivilTime first = core::ToCivil(core::ToUtc(drive->fixes.front().time));
  EXPECT_EQ(first.year, 2025);
  EXPECT_EQ(first.month, 7);
  EXPECT_EQ(first.day, 8);
  EXPECT_EQ(first.hour, 19);
  EXPECT_EQ(first.minute, 34);
  EXPECT_EQ(first.second, 0);
  EXPECT_EQ(first.nanosecond, 499'000'000);
  EXPECT_NEAR(drive->fixes.front().antenna.lat_rad * core::kDegFromRad, 40.09662680, 1e-12);
  EXPECT_NEAR(core::ToSeconds(drive->end() - drive->begin()), 545.770, 1e-9);
}

TEST(Recording, ShiftMovesEverything) {
  auto drive = LoadRecording(kDrive);
  ASSERT_TRUE(drive);
  const core::GpsTime fix = drive->fixes[5].time;
  const core::GpsTime imu = drive->imu[5].time;
  drive->Shift(core::Seconds(100));
  EXPECT_EQ(drive->fixes[5].time - fix, core::Seconds(100));
  EXPECT_EQ(drive->imu[5].time - imu, core::Seconds(100));
}

/// A small recording whose files a test can spoil.
class BrokenRecording : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "kawara_recording_XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    Write("site.csv",
          "gps_week,imu_late_s,geoid_m,declination_deg,dip_deg,field_gauss\n2374,0,0,0,60,0.5\n");
    Write("imu.csv", "t,wx,wy,wz,ax,ay,az\n10,0,0,0,0,0,-9.8\n11,0,0,0,0,0,-9.8\n");
    Write("gnss.csv", kGnssHeader + "10,40,-105,1600,0.01,0.01,0.01,1,20,0,0,0,0.1,0.1,0.1\n" +
                          "11,40,-105,1600,0.01,0.01,0.01,1,20,0,0,0,0.1,0.1,0.1\n");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void Write(const char* name, const std::string& text) { std::ofstream(folder_ / name) << text; }
  void ExpectError(const std::string& must_say) {
    const auto recording = LoadRecording(folder_);
    ASSERT_FALSE(recording);
    EXPECT_NE(recording.error().message.find(must_say), std::string::npos)
        << recording.error().message;
  }

  const std::string kGnssHeader = "t,lat,lon,h,sdN,sdE,sdD,q,nsat,vN,vE,vD,sdvN,sdvE,sdvD\n";
  std::filesystem::path folder_;
};

TEST_F(BrokenRecording, UnbrokenItLoads) { EXPECT_TRUE(LoadRecording(folder_)); }
TEST_F(BrokenRecording, MissingFileIsNamed) {
  std::filesystem::remove(folder_ / "imu.csv");
  ExpectError("imu.csv.gz exists");
}
TEST_F(BrokenRecording, MissingColumnIsNamed) {
  Write("imu.csv", "t,wx,wy,wz,ax,ay\n10,0,0,0,0,0\n");
  ExpectError("imu.csv:1: no column 'az'");
}
TEST_F(BrokenRecording, BadNumberHasLineAndColumn) {
  Write("imu.csv", "t,wx,wy,wz,ax,ay,az\n10,0,0,0,0,0,-9.8\n11,0,zero,0,0,0,-9.8\n");
  ExpectError("imu.csv:3: column wy: not a number: 'zero'");
}
TEST_F(BrokenRecording, ShortLineIsNamed) {
  Write("imu.csv", "t,wx,wy,wz,ax,ay,az\n10,0,0,0,0,0\n");
  ExpectError("imu.csv:2: column count: expected 7 fields, found 6");
}
TEST_F(BrokenRecording, TimeMustIncrease) {
  Write("imu.csv", "t,wx,wy,wz,ax,ay,az\n10,0,0,0,0,0,-9.8\n10,0,0,0,0,0,-9.8\n");
  ExpectError("imu.csv:3: column t:");
}
TEST_F(BrokenRecording, NotANumberIsNoLatitude) {
  Write("gnss.csv", kGnssHeader + "10,nan,-105,1600,0.01,0.01,0.01,1,20,0,0,0,0.1,0.1,0.1\n");
  ExpectError("gnss.csv:2: column lat");
}
TEST_F(BrokenRecording, StreamsMustOverlap) {
  Write("imu.csv", "t,wx,wy,wz,ax,ay,az\n100,0,0,0,0,0,-9.8\n101,0,0,0,0,0,-9.8\n");
  ExpectError("overlap in time");
}
TEST_F(BrokenRecording, CutOffGzipIsAnError) {
  std::ifstream whole(kDrive / "imu.csv.gz", std::ios::binary);
  std::string bytes(200000, '\0');
  whole.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  std::filesystem::remove(folder_ / "imu.csv");
  Write("imu.csv.gz", bytes);
  ExpectError("imu.csv.gz: damaged or cut off");
}

TEST(MotionTrack, GoesThroughTheFixes) {
  const auto drive = LoadRecording(kDrive);
  ASSERT_TRUE(drive);
  const MotionTrack track(*drive);
  for (std::size_t i = 0; i < drive->fixes.size(); i += 7) {
    const core::Geodetic at = track.PositionAt(drive->fixes[i].time);
    EXPECT_NEAR(at.lat_rad, drive->fixes[i].antenna.lat_rad, 1e-14);
    EXPECT_NEAR(at.lon_rad, drive->fixes[i].antenna.lon_rad, 1e-14);
  }
}

TEST(MotionTrack, BetweenFixesItIsGoodToCentimetres) {
  // Every second fix is taken away and has to come out of its neighbours, twice as far apart as in
  // use.
  auto drive = LoadRecording(kDrive);
  ASSERT_TRUE(drive);
  Recording half = *drive;
  half.fixes.clear();
  for (std::size_t i = 0; i < drive->fixes.size(); i += 2) half.fixes.push_back(drive->fixes[i]);
  const MotionTrack track(half);
  std::vector<double> errors_m;
  for (std::size_t i = 3; i + 3 < drive->fixes.size(); i += 2) {
    errors_m.push_back((core::EcefFromGeodetic(track.PositionAt(drive->fixes[i].time)) -
                        core::EcefFromGeodetic(drive->fixes[i].antenna))
                           .norm());
  }
  std::sort(errors_m.begin(), errors_m.end());
  EXPECT_LT(errors_m[errors_m.size() / 2], 0.03);
  EXPECT_LT(errors_m[errors_m.size() * 95 / 100], 0.10);
}

TEST(MotionTrack, NosePointsAlongTheCourseWhenDrivingStraight) {
  const auto drive = LoadRecording(kDrive);
  ASSERT_TRUE(drive);
  const MotionTrack track(*drive);
  std::vector<double> errors_deg;
  for (const RecordedFix& fix : drive->fixes) {
    const Eigen::Vector3d& v = fix.velocity_ned_mps;
    if (v.head<2>().norm() < 4.0) continue;  // fast: forward, and the course is sharp
    errors_deg.push_back(std::abs(core::WrapPi(std::atan2(v.y(), v.x()) - track.YawAt(fix.time))) *
                         core::kDegFromRad);
  }
  ASSERT_GT(errors_deg.size(), 500U);
  std::sort(errors_deg.begin(), errors_deg.end());
  EXPECT_LT(errors_deg[errors_deg.size() / 2], 2.0);
  EXPECT_LT(errors_deg[errors_deg.size() * 95 / 100],
            8.0);  // in bends the rear axle, not the antenna, follows the nose
}

TEST(MotionTrack, EndsAreHeld) {
  const auto drive = LoadRecording(kDrive);
  ASSERT_TRUE(drive);
  const MotionTrack track(*drive);
  EXPECT_EQ(track.YawAt(drive->imu.front().time - core::Seconds(100)),
            track.YawAt(drive->imu.front().time - core::Seconds(1)));
  EXPECT_NEAR(track.PositionAt(drive->fixes.back().time + core::Seconds(100)).lat_rad,
              drive->fixes.back().antenna.lat_rad, 1e-14);
}

}  // namespace
}  // namespace kawara::sim
