#include "onboard/mapper/report/truth_ranges.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

namespace kawara::mapper {
namespace {

namespace fs = std::filesystem;

class TruthRanges : public ::testing::Test {
 protected:
  void SetUp() override {
    survey_ = fs::temp_directory_path() / ("truth_ranges." + std::to_string(::getpid()));
    fs::create_directories(survey_ / "range");
  }
  void TearDown() override { fs::remove_all(survey_); }
  void Write(const cv::Mat& levels) const {
    ASSERT_TRUE(cv::imwrite((survey_ / "range" / "00007.png").string(), levels));
  }
  fs::path survey_;
};

TEST_F(TruthRanges, MillimetresWithoutWhatIsUnknown) {
  Write((cv::Mat_<std::uint16_t>(2, 2) << 0, 1500, 65534, 65535));
  const auto truth = LoadTruth(survey_, "00007", 2, 2);
  ASSERT_TRUE(truth) << truth.error().message;
  ASSERT_EQ(truth->size(), 4U);
  EXPECT_TRUE(std::isnan((*truth)[0]));
  EXPECT_FLOAT_EQ((*truth)[1], 1.5F);
  EXPECT_FLOAT_EQ((*truth)[2], 65.534F);
  EXPECT_TRUE(std::isnan((*truth)[3]));
}

TEST_F(TruthRanges, ASurveyWithoutTruthIsNoError) {
  const auto truth = LoadTruth(survey_, "00008", 2, 2);
  ASSERT_TRUE(truth) << truth.error().message;
  EXPECT_TRUE(truth->empty());
}

TEST_F(TruthRanges, AnotherSizeIsAnError) {
  Write(cv::Mat(2, 3, CV_16UC1, cv::Scalar(1000)));
  const auto truth = LoadTruth(survey_, "00007", 3, 3);
  ASSERT_FALSE(truth);
  EXPECT_EQ(truth.error().code, core::ErrorCode::kFormat);
  EXPECT_NE(truth.error().message.find("00007.png"), std::string::npos);
}

TEST_F(TruthRanges, EightBitsAreAnError) {
  Write(cv::Mat(2, 2, CV_8UC1, cv::Scalar(100)));
  EXPECT_FALSE(LoadTruth(survey_, "00007", 2, 2));
}

TEST_F(TruthRanges, WhatIsNoPictureIsAnError) {
  for (const char* text : {"", "no picture"}) {
    std::ofstream(survey_ / "range" / "00007.png") << text;
    const auto truth = LoadTruth(survey_, "00007", 2, 2);
    ASSERT_FALSE(truth);
    EXPECT_EQ(truth.error().code, core::ErrorCode::kFormat);
  }
}

}  // namespace
}  // namespace kawara::mapper
