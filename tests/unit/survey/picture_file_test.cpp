#include "onboard/survey/picture_file.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>

namespace kawara::survey {
namespace {

cv::Mat Pattern(int type) {
  cv::Mat picture(40, 60, type);
  cv::randu(picture, cv::Scalar::all(0), cv::Scalar::all(type == CV_16UC1 ? 65535 : 255));
  return picture;
}

std::vector<std::uint8_t> Encoded(const cv::Mat& picture, const std::string& ending) {
  std::vector<std::uint8_t> bytes;
  EXPECT_TRUE(cv::imencode(ending, picture, bytes));
  return bytes;
}

TEST(PictureFile, APngComesBackAsItWas) {
  const cv::Mat bgr = Pattern(CV_8UC3);
  const auto picture = DecodePicture(Encoded(bgr, ".png"));
  ASSERT_TRUE(picture);
  EXPECT_EQ(picture->width_px, 60);
  EXPECT_EQ(picture->height_px, 40);
  for (int c = 0; c < 3; ++c)
    EXPECT_EQ(picture->rgb[3 * 61 + static_cast<std::size_t>(c)], bgr.at<cv::Vec3b>(1, 1)[2 - c]);
}

TEST(PictureFile, GreyIsThreeTimesTheSame) {
  const cv::Mat grey = Pattern(CV_8UC1);
  const auto picture = DecodePicture(Encoded(grey, ".png"));
  ASSERT_TRUE(picture);
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_EQ(picture->rgb[3 * 61 + c], grey.at<std::uint8_t>(1, 1));
}

// What a broken copy leaves, cut anywhere: a decoder would fill up with grey and say nothing.
TEST(PictureFile, WhatEndsEarlyIsRefused) {
  for (const char* ending : {".jpg", ".png"}) {
    const auto whole = Encoded(Pattern(CV_8UC3), ending);
    ASSERT_TRUE(DecodePicture(whole));
    for (std::size_t size = 0; size + 4 < whole.size(); size += 97) {
      EXPECT_FALSE(DecodePicture(std::span(whole).first(size))) << ending << " " << size;
    }
  }
}

TEST(PictureFile, OtherFormatsAreNotTried) {
  EXPECT_FALSE(DecodePicture(Encoded(Pattern(CV_8UC3), ".bmp")));
  EXPECT_FALSE(DecodePicture({}));
}

}  // namespace
}  // namespace kawara::survey
