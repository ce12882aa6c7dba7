#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "sim/evaluate/cloud_errors.hpp"
#include "sim/evaluate/ply_cloud.hpp"
#include "sim/evaluate/range_errors.hpp"

namespace kawara::sim {
namespace {

using ::testing::HasSubstr;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

class FolderTest : public ::testing::Test {
 protected:
  FolderTest() : folder_(std::filesystem::temp_directory_path() / "kawara_model_errors_test") {
    std::filesystem::create_directories(folder_);
  }
  ~FolderTest() override { std::filesystem::remove_all(folder_); }
  std::string File(const char* name) const { return (folder_ / name).string(); }
  std::string Write(const char* name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return File(name);
  }
  std::filesystem::path folder_;
};

TEST(RangeErrors, BandsAreOfTheTrueRangeAndTheUnknownIsNoError) {
  RangeErrors errors;
  const RangeImage truth{6, 1, {3.0F, 3.0F, 5.0F, 8.0F, kInfinity, 1.0F}};
  const RangeImage result{6, 1, {3.125F, kNan, 6.0F, 8.2F, 7.0F, 1.0F}};
  ASSERT_TRUE(errors.Add(truth, result));
  const std::string json = errors.Report().Json();
  EXPECT_THAT(json, HasSubstr(R"("2-6 m": {"unit": "m", "n": 2, "mean": 0.5625,)"));
  EXPECT_THAT(json, HasSubstr(R"("2-6 m with a range": {"unit": "share", "value": 0.666666667})"));
  EXPECT_THAT(json, HasSubstr(R"("2-6 m off by > 0.5 m": {"unit": "share", "value": 0.5})"));
  EXPECT_THAT(json, HasSubstr(R"("ranges where there is sky": {"unit": "pixels", "value": 1})"));
  EXPECT_THAT(errors.HistogramCsv(), HasSubstr("0.10,0.15,1\n"));
  EXPECT_THAT(errors.HistogramCsv(), HasSubstr("0.95,1.00,1\n")) << "the last bin takes the rest";
}

TEST(RangeErrors, SizesMustBeEqual) {
  RangeErrors errors;
  EXPECT_FALSE(errors.Add({2, 1, {1, 1}}, {1, 2, {1, 1}}));
}

TEST_F(FolderTest, RangeImagesOfMillimetresAndOfFloats) {
  const cv::Mat_<std::uint16_t> mm = (cv::Mat_<std::uint16_t>(1, 3) << 0, 1500, 65535);
  ASSERT_TRUE(cv::imwrite(File("mm.png"), mm));
  const auto from_mm = ReadRangeImage(File("mm.png"));
  ASSERT_TRUE(from_mm);
  EXPECT_TRUE(std::isnan(from_mm->range_m[0]));
  EXPECT_FLOAT_EQ(from_mm->range_m[1], 1.5F);
  EXPECT_TRUE(std::isinf(from_mm->range_m[2]));
  const cv::Mat_<float> metres = (cv::Mat_<float>(2, 1) << 1.25F, 70.5F);
  ASSERT_TRUE(cv::imwrite(File("m.pfm"), metres));
  const auto from_m = ReadRangeImage(File("m.pfm"));
  ASSERT_TRUE(from_m);
  EXPECT_THAT(from_m->range_m, ::testing::ElementsAre(1.25F, 70.5F));
  const cv::Mat_<std::uint8_t> grey(2, 2, std::uint8_t{7});
  ASSERT_TRUE(cv::imwrite(File("grey.png"), grey));
  EXPECT_FALSE(ReadRangeImage(File("grey.png")));
  EXPECT_FALSE(ReadRangeImage(File("none.png")));
}

/// A wall of points every 2 cm.
std::vector<Eigen::Vector3d> Wall(double width_m, double off_m) {
  std::vector<Eigen::Vector3d> wall;
  for (int i = 0; i < static_cast<int>(std::lround(width_m * 50)); ++i) {
    for (int k = 0; k < 50; ++k) wall.emplace_back(0.01 + i * 0.02, off_m, 0.01 + k * 0.02);
  }
  return wall;
}

TEST(CompareClouds, HalfTheWallSevenCentimetresOff) {
  const auto report = CompareClouds(Wall(2, 0.01), Wall(1, 0.08), 0.1);
  ASSERT_TRUE(report);
  const std::string json = report->Json();
  EXPECT_THAT(
      json, HasSubstr(R"j("accuracy (result to truth)": {"unit": "m", "n": 2500, "mean": 0.07,)j"));
  EXPECT_THAT(json, HasSubstr(R"("precision within 5 cm": {"unit": "share", "value": 0})"));
  EXPECT_THAT(json, HasSubstr(R"("precision within 10 cm": {"unit": "share", "value": 1})"));
  EXPECT_THAT(json,
              HasSubstr(R"j("voxels right (of the result's)": {"unit": "share", "value": 1})j"));
  EXPECT_THAT(json,
              HasSubstr(R"j("voxels found (of the truth's)": {"unit": "share", "value": 0.5})j"));
}

TEST(CompareClouds, AnEmptyCloudIsRefused) {
  EXPECT_FALSE(CompareClouds({}, Wall(1, 0), 0.1));
  EXPECT_FALSE(CompareClouds(Wall(1, 0), {}, 0.1));
}

TEST_F(FolderTest, PlyComesBackAsWritten) {
  const std::vector<Eigen::Vector3d> points{{1, 2, 3}, {-4.5, 0.25, 1e3}};
  ASSERT_TRUE(WritePlyPoints(File("a.ply"), points));
  const auto read = ReadCloudPoints(File("a.ply"));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(*read, points);
}

TEST_F(FolderTest, PlyThatIsCutOffIsRefused) {
  ASSERT_TRUE(WritePlyPoints(File("a.ply"), {{1, 2, 3}, {4, 5, 6}}));
  std::filesystem::resize_file(File("a.ply"), std::filesystem::file_size(File("a.ply")) - 1);
  const auto read = ReadCloudPoints(File("a.ply"));
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().message, HasSubstr("ends after 1 of 2 points"));
}

}  // namespace
}  // namespace kawara::sim
