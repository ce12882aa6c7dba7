#include "sim/evaluate/object_errors.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace kawara::sim {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

ApexBox Box(const std::string& id, double east, double north, double length, double width,
            double height, double heading_deg, std::size_t first_corner = 0) {
  ApexBox box;
  box.id = id;
  const double h = heading_deg * core::kRadFromDeg;
  const Eigen::Vector2d along(std::sin(h), std::cos(h)), right(std::cos(h), -std::sin(h));
  const std::array<Eigen::Vector2d, 4> corners{
      along * length / 2 - right * width / 2, along * length / 2 + right * width / 2,
      -along * length / 2 + right * width / 2, -along * length / 2 - right * width / 2};
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d c = corners[(i + first_corner) % 4] + Eigen::Vector2d(east, north);
    box.apexes_enu_m[i] = {c.x(), c.y(), 0.0};
    box.apexes_enu_m[i + 4] = {c.x(), c.y(), height};
  }
  return box;
}

TEST(ApexBox, TellsItsSizeAndHeading) {
  for (const std::size_t corner : {0U, 1U, 2U, 3U}) {
    const ApexBox box = Box("a", 10, 20, 6, 2, 3, 150, corner);
    EXPECT_TRUE(box.Size().isApprox(Eigen::Vector3d(6, 2, 3), 1e-9));
    EXPECT_NEAR(box.Heading() * core::kDegFromRad, 150, 1e-9);
    EXPECT_TRUE(box.Centre().isApprox(Eigen::Vector3d(10, 20, 1.5), 1e-9));
  }
}

TEST(IntersectionOverUnion, KnownAnswers) {
  const ApexBox a = Box("a", 0, 0, 4, 2, 2, 0);
  EXPECT_NEAR(IntersectionOverUnion(a, Box("b", 0, 0, 4, 2, 2, 180, 2)), 1.0, 1e-9);
  EXPECT_NEAR(IntersectionOverUnion(a, Box("b", 1, 0, 4, 2, 2, 0)), 1.0 / 3.0, 1e-9);
  EXPECT_NEAR(IntersectionOverUnion(a, Box("b", 0, 0, 4, 2, 1, 0)), 0.5, 1e-9);
  EXPECT_NEAR(IntersectionOverUnion(a, Box("b", 0, 0, 4, 2, 2, 90)), 4.0 / 12.0, 1e-9);
  EXPECT_EQ(IntersectionOverUnion(a, Box("b", 5, 0, 4, 2, 2, 0)), 0.0);
  // Two unit squares, one turned by 45 degrees: a regular octagon, 2 (sqrt 2 - 1).
  const double octagon = 2 * (std::sqrt(2.0) - 1);
  EXPECT_NEAR(IntersectionOverUnion(Box("a", 0, 0, 1, 1, 1, 0), Box("b", 0, 0, 1, 1, 1, 45)),
              octagon / (2 - octagon), 1e-9);
}

TEST(MatchBoxes, EachBoxOnceBestOverlapFirst) {
  const std::vector<ApexBox> truth{Box("t0", 0, 0, 4, 2, 2, 0), Box("t1", 3, 0, 4, 2, 2, 0),
                                   Box("t2", 50, 0, 1, 1, 1, 0)};
  const std::vector<ApexBox> result{Box("r0", 0.4, 0, 4, 2, 2, 0), Box("r1", 1.2, 0, 4, 2, 2, 0),
                                    Box("r2", 51.5, 0, 1, 1, 1, 0), Box("r3", 90, 0, 1, 1, 1, 0)};
  EXPECT_THAT(MatchBoxes(truth, result), ElementsAre(Pair(0, 0), Pair(1, 1), Pair(2, 2)));
}

TEST(CompareObjects, CountsAndErrors) {
  const std::vector<ApexBox> truth{Box("truck", 0, 0, 6, 2, 3, 179),
                                   Box("car", 20, 0, 4, 2, 1.5, 0)};
  const std::vector<ApexBox> result{Box("1", 0.3, 0.4, 6.2, 1.9, 3.1, 1, 1),
                                    Box("2", 40, 0, 1, 1, 1, 0)};
  const std::string json = CompareObjects(truth, result).Json();
  EXPECT_THAT(json, HasSubstr(R"("found": {"unit": "objects", "value": 1})"));
  EXPECT_THAT(json, HasSubstr(R"("missed": {"unit": "objects", "value": 1})"));
  EXPECT_THAT(json, HasSubstr(R"("false": {"unit": "objects", "value": 1})"));
  EXPECT_THAT(json, HasSubstr(R"("centre, in the plane": {"unit": "m", "n": 1, "mean": 0.5,)"));
  EXPECT_THAT(json, HasSubstr(R"("heading": {"unit": "deg", "n": 1, "mean": 2,)"))
      << "from 179 to 1 are two degrees";
  const std::string list = ListObjects(truth, result);
  EXPECT_THAT(list, HasSubstr("found  truck () as 1: centre 0.50 m"));
  EXPECT_THAT(list, HasSubstr("missed car"));
  EXPECT_THAT(list, HasSubstr("false  2"));
}

TEST(CompareObjects, ApexesMayStartAtAnyCorner) {
  const std::vector<ApexBox> truth{Box("a", 0, 0, 6, 2, 3, 30)};
  for (const std::size_t corner : {1U, 2U, 3U}) {
    const std::vector<ApexBox> result{Box("a", 0, 0, 6, 2, 3, 30, corner)};
    EXPECT_THAT(CompareObjects(truth, result).Json(),
                HasSubstr(R"("apexes": {"unit": "m", "n": 1, "mean": 0,)"));
  }
}

TEST(ReadBoxes, BoxesComeBackFromTheirApexes) {
  const core::LocalEnu plane({0.62, 2.43, 50.0});
  const ApexBox box = Box("truck", 12, -7, 6, 2, 3, 30);
  const std::string path = ::testing::TempDir() + "kawara_boxes.csv";
  {
    std::ofstream file(path);
    file.precision(14);
    file << "id,class";
    for (int i = 0; i < 8; ++i) {
      const std::string apex = "apex" + std::to_string(i);
      file << "," << apex << "_lon_deg," << apex << "_lat_deg," << apex << "_h_m";
    }
    file << ",t_end";
    // The second row is history: it says what was there before.
    for (const char* end : {"", "2026-11-22T12:00:05.000Z"}) {
      file << "\ntruck,truck";
      for (const Eigen::Vector3d& apex : box.apexes_enu_m) {
        const core::Geodetic g = plane.ToGeodetic(apex);
        file << "," << g.lon_rad * core::kDegFromRad << "," << g.lat_rad * core::kDegFromRad << ","
             << g.h_ellipsoidal_m;
      }
      file << "," << end;
    }
    file << "\n";
  }
  const auto boxes = ReadBoxes(path, plane);
  ASSERT_TRUE(boxes) << boxes.error().message;
  ASSERT_EQ(boxes->size(), 1U);
  EXPECT_EQ((*boxes)[0].cls, "truck");
  EXPECT_GT(IntersectionOverUnion((*boxes)[0], box), 0.9999);
  const auto place = PlaceOfBoxes(path);
  ASSERT_TRUE(place);
  EXPECT_LT(plane.FromGeodetic(*place).norm(), 20.0);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace kawara::sim
