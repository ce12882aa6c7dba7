#include "drivers/v4l2_mode_choice.hpp"

#include <gtest/gtest.h>
#include <linux/videodev2.h>

namespace kawara::drivers {
namespace {

V4l2SizeOffer Size(std::uint32_t width, std::uint32_t height, std::vector<V4l2Interval> intervals) {
  V4l2SizeOffer size;
  size.min_width = size.max_width = width;
  size.min_height = size.max_height = height;
  size.intervals = std::move(intervals);
  return size;
}

/// A common USB camera: MJPEG large and quick, YUYV large and slow.
std::vector<V4l2FormatOffer> Webcam() {
  return {{V4L2_PIX_FMT_YUYV,
           "YUYV 4:2:2",
           {Size(640, 480, {{1, 30}, {1, 15}}), Size(1920, 1080, {{1, 5}})}},
          {V4L2_PIX_FMT_MJPEG,
           "Motion-JPEG",
           {Size(640, 480, {{1, 60}, {1, 30}}), Size(1920, 1080, {{1001, 30000}, {1, 15}})}},
          {V4L2_PIX_FMT_H264, "H.264", {Size(3840, 2160, {{1, 30}})}}};
}

TEST(V4l2ModeChoice, RateThenAreaThenFormatThenTheSlowest) {
  struct {
    V4l2ModeWish wish;
    V4l2Mode mode;
  } const cases[] = {
      {{0, 0, 10.0, ""}, {V4L2_PIX_FMT_MJPEG, 1920, 1080, {1, 15}}},
      {{0, 0, 30.0, ""}, {V4L2_PIX_FMT_MJPEG, 1920, 1080, {1001, 30000}}},  // 29.97 is 30
      {{0, 0, 31.0, ""}, {V4L2_PIX_FMT_MJPEG, 640, 480, {1, 60}}},
      {{0, 0, 1.0, ""}, {V4L2_PIX_FMT_MJPEG, 1920, 1080, {1, 15}}},
      {{0, 0, 10.0, "YUYV"}, {V4L2_PIX_FMT_YUYV, 640, 480, {1, 15}}},
      {{0, 0, 4.0, "YUYV"}, {V4L2_PIX_FMT_YUYV, 1920, 1080, {1, 5}}},
      {{640, 480, 10.0, ""}, {V4L2_PIX_FMT_MJPEG, 640, 480, {1, 30}}},
  };
  for (const auto& one : cases) {
    const auto mode = ChooseV4l2Mode(Webcam(), one.wish);
    ASSERT_TRUE(mode) << mode.error().message;
    EXPECT_EQ(*mode, one.mode) << TextOf(*mode);
  }
}

TEST(V4l2ModeChoice, FormatsInTheirOrderWhereAllElseIsEqual) {
  std::vector<V4l2FormatOffer> offers;
  for (const std::uint32_t fourcc :
       {V4L2_PIX_FMT_GREY, V4L2_PIX_FMT_SRGGB8, V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_NV12}) {
    offers.push_back({fourcc, "", {Size(640, 480, {{1, 30}})}});
    EXPECT_EQ(ChooseV4l2Mode(offers, {})->fourcc, fourcc);
  }
}

TEST(V4l2ModeChoice, WhatIsNotThereIsAnsweredWithAllThatIs) {
  for (const V4l2ModeWish& wish :
       {V4l2ModeWish{0, 0, 61.0, ""}, V4l2ModeWish{800, 600, 10.0, ""},
        V4l2ModeWish{1920, 1080, 10.0, "YUYV"}, V4l2ModeWish{0, 0, 10.0, "NV12"}}) {
    const auto mode = ChooseV4l2Mode(Webcam(), wish);
    ASSERT_FALSE(mode);
    EXPECT_EQ(mode.error().code, core::ErrorCode::kInvalidArgument);
    EXPECT_NE(mode.error().message.find(
                  "it offers: YUYV 640x480 at 30 15 Hz, 1920x1080 at 5 Hz; MJPG 640x480 at 60 30 "
                  "Hz, 1920x1080 at 29.97 15 Hz; H264 3840x2160 at 30 Hz"),
              std::string::npos)
        << mode.error().message;
  }
  EXPECT_NE(ChooseV4l2Mode({}, {}).error().message.find("it offers: nothing"), std::string::npos);
}

TEST(V4l2ModeChoice, RastersOfSizesAndRangesOfRates) {
  V4l2SizeOffer raster;
  raster.min_width = 32, raster.max_width = 4056, raster.step_width = 8;
  raster.min_height = 32, raster.max_height = 3040, raster.step_height = 2;
  const std::vector<V4l2FormatOffer> untold{{V4L2_PIX_FMT_SBGGR8, "", {raster}}};
  EXPECT_EQ(*ChooseV4l2Mode(untold, {0, 0, 30.0, ""}),
            (V4l2Mode{V4L2_PIX_FMT_SBGGR8, 4056, 3040, {}}));
  EXPECT_TRUE(ChooseV4l2Mode(untold, {1440, 1440, 30.0, "BGGR"}));
  EXPECT_FALSE(ChooseV4l2Mode(untold, {1441, 1440, 30.0, ""}));
  EXPECT_FALSE(ChooseV4l2Mode(untold, {4064, 3040, 30.0, ""}));

  raster.intervals = {{1, 60}, {1, 5}};
  raster.any_rate_between = true;
  const std::vector<V4l2FormatOffer> range{{V4L2_PIX_FMT_SBGGR8, "", {raster}}};
  EXPECT_EQ(ChooseV4l2Mode(range, {0, 0, 12.5, ""})->interval, (V4l2Interval{1000, 12500}));
  EXPECT_EQ(ChooseV4l2Mode(range, {0, 0, 2.0, ""})->interval, (V4l2Interval{1, 5}));
  EXPECT_FALSE(ChooseV4l2Mode(range, {0, 0, 61.0, ""}));
}

TEST(V4l2Formats, NamesAndFourCharacters) {
  for (const V4l2PixelFormat& format : V4l2PixelFormats()) {
    EXPECT_EQ(FindV4l2PixelFormat(format.fourcc), &format);
    EXPECT_EQ(FindV4l2PixelFormat(std::string_view(format.name)), &format);
    EXPECT_EQ(FourccText(format.fourcc), format.name);
  }
  EXPECT_EQ(FindV4l2PixelFormat("H264"), nullptr);
  EXPECT_EQ(FourccText(V4L2_PIX_FMT_H264), "H264");
  EXPECT_EQ(FourccText(0x01020304), "....");
}

}  // namespace
}  // namespace kawara::drivers
