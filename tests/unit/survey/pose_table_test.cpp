#include "onboard/survey/pose_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kawara::survey {
namespace {

using ::testing::HasSubstr;

PoseTable Parsed(const std::string& text, BodyAxes body = BodyAxes::kForwardRightDown) {
  auto table = ParsePoses(text, "p.csv", body);
  EXPECT_TRUE(table) << table.error().message;
  return table ? *table : PoseTable{};
}

Eigen::Vector3d Axis(const PoseRow& row, int axis) { return row.map_from_body.linear().col(axis); }

TEST(PoseTable, GeodeticPosesAreEastNorthUpFromTheFirst) {
  const PoseTable table = Parsed(
      "frame,gps_ns,lat_deg,lon_deg,h_ellipsoidal_m,roll_deg,pitch_deg,yaw_deg,sd_east_m,sd_north_"
      "m,"
      "sd_up_m,sd_attitude_deg\n"
      "00001,1400000000000000001,35.66,139.79,40,0,0,90,0.02,0.03,0.04,0.1\n"
      "00002,1400000001000000000,35.66,139.79001,42,0,10,0,0.02,0.03,0.04,0.1\n");
  ASSERT_EQ(table.rows.size(), 2U);
  ASSERT_TRUE(table.origin);
  EXPECT_NEAR(table.origin->lat_rad, 35.66 * core::kRadFromDeg, 1e-12);
  EXPECT_EQ(table.rows[0].time.ns(), 1400000000000000001);
  EXPECT_LT(table.rows[0].map_from_body.translation().norm(), 1e-9);
  // 1e-5 deg of longitude at 35.66 deg: a cos(lat) / sqrt(1 - e^2 sin^2 lat) * 1.745e-7 = 0.9055 m.
  EXPECT_TRUE(
      table.rows[1].map_from_body.translation().isApprox(Eigen::Vector3d(0.90551, 0.0, 2.0), 1e-4));
  EXPECT_TRUE(Axis(table.rows[0], 0).isApprox(Eigen::Vector3d(1, 0, 0), 1e-9)) << "yaw 90: east";
  EXPECT_TRUE(Axis(table.rows[0], 2).isApprox(Eigen::Vector3d(0, 0, -1), 1e-9)) << "down";
  EXPECT_NEAR(Axis(table.rows[1], 0).z(), std::sin(10 * core::kRadFromDeg), 1e-6) << "nose up";
  EXPECT_TRUE(table.rows[0].has_covariance);
  EXPECT_NEAR(table.rows[0].covariance(1, 1), 0.03 * 0.03, 1e-15);
  EXPECT_NEAR(table.rows[0].covariance(4, 4), std::pow(0.1 * core::kRadFromDeg, 2), 1e-15);
}

// A kilometre away, north and down have turned against the map's by the Earth's curvature.
TEST(PoseTable, FarFromTheOriginAttitudeFollowsTheEarth) {
  const PoseTable table =
      Parsed("lat_deg,lon_deg,h_m,roll_deg,pitch_deg,yaw_deg\n35,139,0,0,0,0\n35.01,139,0,0,0,0\n");
  const double turned_rad = std::acos(-Axis(table.rows[1], 2).z());
  EXPECT_NEAR(turned_rad, 0.01 * core::kRadFromDeg, 1e-8);
  EXPECT_LT(Axis(table.rows[1], 2).y(), 0.0) << "down there leans back towards the origin";
}

TEST(PoseTable, MetricAnglesAndQuaternionSayTheSame) {
  const std::string angles = "x,y,z,roll_deg,pitch_deg,yaw_deg\n1,2,3,0,0,90\n";
  const PoseRow up = Parsed(angles, BodyAxes::kForwardLeftUp).rows.at(0);
  EXPECT_TRUE(Axis(up, 0).isApprox(Eigen::Vector3d(0, 1, 0), 1e-12)) << "counterclockwise";
  EXPECT_TRUE(Axis(up, 2).isApprox(Eigen::Vector3d(0, 0, 1), 1e-12));
  const PoseRow down = Parsed(angles).rows.at(0);
  EXPECT_TRUE(Axis(down, 0).isApprox(Eigen::Vector3d(0, 1, 0), 1e-12)) << "the same heading";
  EXPECT_TRUE(Axis(down, 2).isApprox(Eigen::Vector3d(0, 0, -1), 1e-12));
  const PoseRow quaternion =
      Parsed("z,y,x,qz,qw,qx,qy\n3,2,1,0.70710678118,0.70710678118,0,0\n").rows.at(0);
  EXPECT_TRUE(quaternion.map_from_body.isApprox(up.map_from_body, 1e-9));
}

TEST(PoseTable, TumLinesKeepTheirNanoseconds) {
  const PoseTable table = Parsed("# t x y z qx qy qz qw\n1700000000.123456789 1 2  3 0 0 0 1\n");
  EXPECT_EQ(table.rows.at(0).time.ns(), 1700000000123456789);
  EXPECT_FALSE(table.origin);
  EXPECT_FALSE(table.rows[0].has_covariance);
  EXPECT_EQ(table.rows[0].map_from_body.translation(), Eigen::Vector3d(1, 2, 3));
}

// What spreadsheets and loggers make of the same two poses.
TEST(PoseTable, OtherPeoplesTablesSayTheSame) {
  const PoseTable plain =
      Parsed("frame,x,y,z,qw,qx,qy,qz\na 1.jpg,0.5,2,3,1,0,0,0\nb.jpg,1.5,2,3,1,0,0,0\n");
  const char* tables[] = {
      "frame,x,y,z,qw,qx,qy,qz\r\na 1.jpg,0.5,2,3,1,0,0,0\r\nb.jpg,1.5,2,3,1,0,0,0",
      "note,frame,x,y,z,qw,qx,qy,qz\n\"a, b\",\"a 1.jpg\",0.5,2,3,1,0,0,0\n,b.jpg,1.5,2,3,1,0,0,0",
      "frame;x;y;z;qw;qx;qy;qz\na 1.jpg;0,5;2;3;1;0;0;0\nb.jpg;1,5;2;3;1;0;0;0\n",
      "\"frame\" , \"x\" , \"y\",\"z\",\"qw\",\"qx\",\"qy\",\"qz\"\n"
      "\"a 1.jpg\",\"0.5\",\"2\",\"3\",\"1\",\"0\",\"0\",\"0\"\n b.jpg , 1.5 ,2,3,1,0,0,0\n",
      "frame,x,y,z,qw,qx,qy,qz\na 1.jpg,0.5,2,3,1,0,0,0,\nb.jpg,1.5,2,3,1,0,0,0,,\n",
  };
  for (const char* text : tables) {
    const PoseTable table = Parsed(text);
    ASSERT_EQ(table.rows.size(), 2U) << text;
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(table.rows[i].name, plain.rows[i].name) << text;
      EXPECT_EQ(table.rows[i].map_from_body.translation(),
                plain.rows[i].map_from_body.translation())
          << text;
    }
  }
}

TEST(PoseTable, RowsThatKnowNoPlaceAreLeftOutAndCounted) {
  const PoseTable table = Parsed(
      "frame,x,y,z,qw,qx,qy,qz\n1,0,0,0,1,0,0,0\n2,,,,,,,\n3,NaN,nan,NAN,1,0,0,0\n4,1,0,0,1,0,0,"
      "0\n");
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_EQ(table.rows[1].name, "4");
  EXPECT_EQ(table.rows_without_place, 2);
}

TEST(PoseTable, MistakesAreToldWithTheirLine) {
  const struct {
    const char* text;
    const char* expected;
  } cases[] = {
      {"", "no poses"},
      {"x,y,z\n", "p.csv:1: columns qw"},
      {"qw,qx,qy,qz,x,y\n", "p.csv:1: columns lat_deg"},
      {"x,y,z,qw,qx,qy,qz\n1,2,3,1,0,0\n", "p.csv:2: 6 fields, the header has 7"},
      {"x,y,z,qw,qx,qy,qz\n\n1,2,a,1,0,0,0\n", "p.csv:3: z: expected a number"},
      {"x,y,z,qw,qx,qy,qz\n1,2,nan,1,0,0,0\n", "z: expected a number"},
      {"x,y,z,qw,qx,qy,qz\n1,2,3,2,0,0,0\n", "quaternion of length 2"},
      {"lat_deg,lon_deg,h,roll_deg,pitch_deg,yaw_deg\n95,0,0,0,0,0\n", "not on the Earth"},
      {"t,x,y,z,qw,qx,qy,qz\nnoon,2,3,1,0,0,0,0\n", "t: expected seconds"},
      {"1,2,3,4,5\n", "expected a header"},
  };
  for (const auto& c : cases) {
    const auto table = ParsePoses(c.text, "p.csv", BodyAxes::kForwardRightDown);
    ASSERT_FALSE(table) << c.text;
    EXPECT_THAT(table.error().message, HasSubstr(c.expected)) << c.text;
  }
}

}  // namespace
}  // namespace kawara::survey
