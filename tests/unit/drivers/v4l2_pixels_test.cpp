#include "drivers/v4l2_pixels.hpp"

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <cmath>
#include <random>

namespace kawara::drivers {
namespace {

V4l2PictureFormat Format(std::uint32_t fourcc, std::uint32_t width, std::uint32_t height,
                         std::uint32_t stride) {
  V4l2PictureFormat format;
  format.fourcc = fourcc;
  format.width_px = width;
  format.height_px = height;
  format.stride_bytes = stride;
  return format;
}

/// YCbCr of a colour by the standards' own formulas (BT.601-7 2.5, BT.709-6 3), in real numbers.
struct Yuv {
  double y, cb, cr;
};
Yuv YuvOf(double r, double g, double b, bool bt709, bool full) {
  const double kr = bt709 ? 0.2126 : 0.299, kb = bt709 ? 0.0722 : 0.114;
  const double y = kr * r + (1 - kr - kb) * g + kb * b;
  const double cb = (b - y) / (2 * (1 - kb)), cr = (r - y) / (2 * (1 - kr));
  if (full) return {y, cb + 128, cr + 128};
  return {16 + y * 219 / 255, 128 + cb * 224 / 255, 128 + cr * 224 / 255};
}
std::uint8_t Byte(double value) { return static_cast<std::uint8_t>(std::lround(value)); }

TEST(V4l2Pixels, ColoursOfBothMatricesAndRanges) {
  const std::array<std::array<double, 3>, 8> colours{{{255, 255, 255},
                                                      {0, 0, 0},
                                                      {255, 0, 0},
                                                      {0, 255, 0},
                                                      {0, 0, 255},
                                                      {120, 60, 200},
                                                      {17, 240, 99},
                                                      {128, 128, 128}}};
  for (const bool bt709 : {false, true}) {
    for (const bool full : {false, true}) {
      for (const auto& [r, g, b] : colours) {
        const Yuv yuv = YuvOf(r, g, b, bt709, full);
        const std::uint8_t y = Byte(yuv.y), cb = Byte(std::min(yuv.cb, 255.0)),
                           cr = Byte(std::min(yuv.cr, 255.0));
        V4l2PictureFormat format = Format(V4L2_PIX_FMT_YUYV, 2, 1, 4);
        format.bt709 = bt709;
        format.full_range = full;
        const auto yuyv = ConvertV4l2Pixels(format, std::vector<std::uint8_t>{y, cb, y, cr});
        format = Format(V4L2_PIX_FMT_NV12, 2, 2, 2);
        format.bt709 = bt709;
        format.full_range = full;
        const auto nv12 = ConvertV4l2Pixels(format, std::vector<std::uint8_t>{y, y, y, y, cb, cr});
        ASSERT_TRUE(yuyv && nv12);
        const double expected[] = {r, g, b};
        for (std::size_t i = 0; i < nv12->bytes.size(); ++i) {
          // Whole numbers of Y, Cb and Cr carry a colour to within two of its steps.
          EXPECT_NEAR(nv12->bytes[i], expected[i % 3], 2.0) << bt709 << full << " " << r << g << b;
          EXPECT_EQ(yuyv->bytes[i % 6], nv12->bytes[i]);
        }
      }
    }
  }
}

TEST(V4l2Pixels, PlacesOfTheSamplesAndPaddedRows) {
  // Two rows, rows of 6 bytes where 4 are used; luma tells the place, chroma is neutral.
  V4l2PictureFormat format = Format(V4L2_PIX_FMT_YUYV, 2, 2, 6);
  format.full_range = true;
  const auto yuyv = ConvertV4l2Pixels(
      format, std::vector<std::uint8_t>{10, 128, 20, 128, 99, 99, 30, 128, 40, 128});
  ASSERT_TRUE(yuyv);
  EXPECT_EQ(yuyv->bytes,
            (std::vector<std::uint8_t>{10, 10, 10, 20, 20, 20, 30, 30, 30, 40, 40, 40}));

  format = Format(V4L2_PIX_FMT_NV12, 4, 2, 6);
  format.full_range = true;
  // The second pair of columns has its own chroma: more red there.
  const auto nv12 = ConvertV4l2Pixels(
      format, std::vector<std::uint8_t>{10, 20, 30, 40, 99, 99, 50, 60, 70, 80, 99, 99,  //
                                        128, 128, 128, 138});
  ASSERT_TRUE(nv12);
  EXPECT_EQ(nv12->bytes[0], 10);
  EXPECT_EQ(nv12->bytes[3 * 5], 60);
  EXPECT_EQ(nv12->bytes[3 * 2], 30 + 14);  // 1.402 * 10
  EXPECT_EQ(nv12->bytes[3 * 7], 80 + 14);
  EXPECT_EQ(nv12->bytes[3 * 7 + 2], 80);
}

/// A plain colour through each raster gives that colour everywhere, borders too.
TEST(V4l2Pixels, BayerOfAPlainColourIsThatColour) {
  struct {
    std::uint32_t fourcc;
    const char* cell;  ///< colours of the first two rows
  } const rasters[] = {{V4L2_PIX_FMT_SRGGB8, "RGGB"},
                       {V4L2_PIX_FMT_SBGGR8, "BGGR"},
                       {V4L2_PIX_FMT_SGBRG8, "GBRG"},
                       {V4L2_PIX_FMT_SGRBG8, "GRBG"}};
  for (const auto& raster : rasters) {
    for (const auto& [width, height] :
         {std::pair<std::uint32_t, std::uint32_t>{2, 2}, {6, 4}, {5, 3}}) {
      const std::uint32_t stride = width + 3;
      std::vector<std::uint8_t> bytes(std::size_t{stride} * height, 77);
      for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
          const char colour = raster.cell[2 * (y % 2) + x % 2];
          bytes[y * stride + x] = colour == 'R' ? 200 : colour == 'G' ? 100 : 50;
        }
      }
      const auto rgb = ConvertV4l2Pixels(Format(raster.fourcc, width, height, stride), bytes);
      ASSERT_TRUE(rgb);
      ASSERT_EQ(rgb->bytes.size(), 3U * width * height);
      for (std::size_t i = 0; i < rgb->bytes.size(); i += 3) {
        EXPECT_EQ(rgb->bytes[i], 200) << raster.cell;
        EXPECT_EQ(rgb->bytes[i + 1], 100) << raster.cell;
        EXPECT_EQ(rgb->bytes[i + 2], 50) << raster.cell;
      }
    }
  }
}

/// A slope in each colour is met exactly inside, since means of neighbours are those of a plane.
TEST(V4l2Pixels, BayerOfASlopeIsThatSlope) {
  const std::uint32_t width = 8, height = 8;
  std::vector<std::uint8_t> bytes;
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      const bool red = x % 2 == 0 && y % 2 == 0, blue = x % 2 == 1 && y % 2 == 1;
      bytes.push_back(static_cast<std::uint8_t>((red ? 20 : blue ? 160 : 90) + 4 * x + 2 * y));
    }
  }
  const auto rgb = ConvertV4l2Pixels(Format(V4L2_PIX_FMT_SRGGB8, width, height, width), bytes);
  ASSERT_TRUE(rgb);
  for (std::uint32_t y = 1; y + 1 < height; ++y) {
    for (std::uint32_t x = 1; x + 1 < width; ++x) {
      const std::uint8_t* const pixel = &rgb->bytes[3 * (y * width + x)];
      const std::uint32_t slope = 4 * x + 2 * y;
      EXPECT_EQ(pixel[0], 20 + slope);
      EXPECT_EQ(pixel[1], 90 + slope);
      EXPECT_EQ(pixel[2], 160 + slope);
    }
  }
}

TEST(V4l2Pixels, CutOffOrSenselessIsRefused) {
  struct {
    V4l2PictureFormat format;
    std::size_t bytes;
    core::ErrorCode code;
  } const cases[] = {
      {Format(V4L2_PIX_FMT_YUYV, 4, 2, 10), 17, core::ErrorCode::kFormat},
      {Format(V4L2_PIX_FMT_NV12, 4, 2, 4), 11, core::ErrorCode::kFormat},
      {Format(V4L2_PIX_FMT_GREY, 4, 2, 4), 0, core::ErrorCode::kFormat},
      {Format(V4L2_PIX_FMT_YUYV, 3, 2, 10), 100, core::ErrorCode::kInvalidArgument},
      {Format(V4L2_PIX_FMT_NV12, 4, 3, 4), 100, core::ErrorCode::kInvalidArgument},
      {Format(V4L2_PIX_FMT_YUYV, 4, 2, 7), 100, core::ErrorCode::kInvalidArgument},
      {Format(V4L2_PIX_FMT_SRGGB8, 1, 2, 1), 100, core::ErrorCode::kInvalidArgument},
      {Format(V4L2_PIX_FMT_GREY, 0, 0, 0), 100, core::ErrorCode::kInvalidArgument},
      {Format(V4L2_PIX_FMT_MJPEG, 4, 2, 0), 100, core::ErrorCode::kInvalidArgument},
      {Format(V4L2_PIX_FMT_H264, 4, 2, 8), 100, core::ErrorCode::kInvalidArgument},
  };
  for (const auto& one : cases) {
    const auto got = ConvertV4l2Pixels(one.format, std::vector<std::uint8_t>(one.bytes));
    ASSERT_FALSE(got) << FourccText(one.format.fourcc) << one.bytes;
    EXPECT_EQ(got.error().code, one.code) << got.error().message;
    std::vector<std::uint8_t> enough(V4l2PictureBytes(one.format));
    if (one.code == core::ErrorCode::kFormat) {
      EXPECT_TRUE(ConvertV4l2Pixels(one.format, enough));
    }
  }
}

}  // namespace
}  // namespace kawara::drivers
