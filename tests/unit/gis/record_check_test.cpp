#include "gis/record_check.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>

#include "fixture.hpp"

namespace kawara::gis {
namespace {

using namespace testing;
using ::testing::HasSubstr;

struct HostilePose {
  const char* name;
  std::function<void(PoseRecord&)> spoil;
  const char* says;
};
class HostilePoses : public ::testing::TestWithParam<HostilePose> {};

TEST_P(HostilePoses, AreRefused) {
  PoseRecord pose = Pose(1);
  ASSERT_TRUE(CheckRecord(pose));
  GetParam().spoil(pose);
  const auto checked = CheckRecord(pose);
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().code, core::ErrorCode::kInvalidArgument);
  EXPECT_THAT(checked.error().message, HasSubstr(GetParam().says));
}

INSTANTIATE_TEST_SUITE_P(
    , HostilePoses,
    ::testing::Values(
        HostilePose{"LatitudeNan", [](auto& p) { p.pose.lat_deg = std::nan(""); }, "lat_deg"},
        HostilePose{"LatitudeBeyondThePole", [](auto& p) { p.pose.lat_deg = 90.0001; }, "lat_deg"},
        HostilePose{"LongitudeInfinite",
                    [](auto& p) { p.pose.lon_deg = -std::numeric_limits<double>::infinity(); },
                    "lon_deg"},
        HostilePose{"HeightInSpace", [](auto& p) { p.pose.h_ellipsoidal_m = 1e9; }, "h_ellips"},
        HostilePose{"YawNan", [](auto& p) { p.pose.yaw_deg = std::nan(""); }, "attitude"},
        HostilePose{
            "VelocityInfinite",
            [](auto& p) { p.pose.velocity_enu_mps[1] = std::numeric_limits<double>::infinity(); },
            "velocity"},
        HostilePose{"AccuracyNegative", [](auto& p) { p.pose.position_sd_enu_m[0] = -1; },
                    "accuracy"},
        HostilePose{"StateUnknown", [](auto& p) { p.pose.rtk = static_cast<core::RtkState>(200); },
                    "rtk_state"},
        HostilePose{"NoTime", [](auto& p) { p.pose.time = {}; }, "gps_ns"},
        HostilePose{"TimeBeyondTheCalendar",
                    [](auto& p) { p.pose.time = core::GpsTime::FromNs(INT64_MAX); }, "gps_ns"},
        HostilePose{"NoRobot", [](auto& p) { p.robot.clear(); }, "robot"},
        HostilePose{"RobotTooLong", [](auto& p) { p.robot.assign(65, 'x'); }, "robot"},
        HostilePose{"RobotNotUtf8", [](auto& p) { p.robot = "\xff\xfe"; }, "robot"},
        HostilePose{"MissionWithNewline", [](auto& p) { p.mission = "a\nb"; }, "mission"}),
    [](const auto& test) { return test.param.name; });

TEST(RecordCheck, PicturesMustBeWhatTheySay) {
  PanoramaRecord picture = Panorama(1, PictureStage::kFull);
  EXPECT_TRUE(CheckRecord(picture));
  picture.width = 511;
  EXPECT_FALSE(CheckRecord(picture));
  picture = Panorama(0, PictureStage::kFull);
  EXPECT_FALSE(CheckRecord(picture)) << "epochs count from 1";
  picture = Panorama(1, PictureStage::kFull);
  picture.jpeg = nullptr;
  EXPECT_FALSE(CheckRecord(picture));
}

TEST(RecordCheck, AJpegCutAnywhereIsNoJpeg) {
  const auto whole = Jpeg(640, 320, 200);
  ASSERT_TRUE(CheckJpeg(*whole));
  EXPECT_EQ(CheckJpeg(*whole)->width, 640U);
  EXPECT_EQ(CheckJpeg(*whole)->height, 320U);
  for (std::size_t n = 0; n < whole->size(); ++n)
    EXPECT_FALSE(CheckJpeg(std::span(*whole).first(n))) << n;
}

TEST(RecordCheck, ASegmentMayNotReachBeyondTheFile) {
  auto bytes = *Jpeg(640, 320, 20);
  bytes[4] = 0xff;  // length of the frame header
  EXPECT_FALSE(CheckJpeg(bytes));
}

TEST(RecordCheck, FolderNamesStayInTheirFolder) {
  for (const char* name :
       {"..", ".", "", "/etc", "../../etc/passwd", "a/b", ".hidden", "a b", "救助ロボ"}) {
    const std::string safe = SafePathName(name);
    EXPECT_FALSE(safe.empty());
    EXPECT_NE(safe[0], '.');
    EXPECT_EQ(safe.find('/'), std::string::npos) << safe;
    EXPECT_NE(safe, name);
  }
  EXPECT_EQ(SafePathName("rover-1"), "rover-1");
  EXPECT_EQ(SafePathName("20261122T062523Z"), "20261122T062523Z");
  EXPECT_NE(SafePathName("a/b"), SafePathName("a?b")) << "two robots, one folder";
}

TEST(RecordCheck, TextForPeopleIsMadeClean) {
  EXPECT_EQ(CleanText("plain", 100), "plain");
  EXPECT_EQ(CleanText("two\nlines\x01", 100), "two?lines?");
  EXPECT_EQ(CleanText("瓦版", 100), "瓦版");
  EXPECT_EQ(CleanText("瓦版", 5), "瓦") << "cut at the end of a character";
  EXPECT_EQ(CleanText("\xc0\x80\xed\xa0\x80", 100), "?????") << "overlong, surrogate";
  EXPECT_TRUE(IsCleanText("瓦版", 6));
  EXPECT_FALSE(IsCleanText("瓦版", 5));
}

}  // namespace
}  // namespace kawara::gis
