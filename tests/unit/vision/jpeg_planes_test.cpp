#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "vision/jpeg.hpp"
#include "vision/jpeg_error.hpp"
#include "vision/yuv420.hpp"
#include "vision_test_support.hpp"

/// The decoder's and the encoder's way without RGB, against their way with it.
namespace kawara::vision {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes Encoded(const TestImage& image, const JpegOptions& options = {.quality = 95}) {
  JpegEncoder encoder;
  const auto jpeg = encoder.Encode(image.view(), options);
  EXPECT_TRUE(jpeg);
  return {jpeg->begin(), jpeg->end()};
}

// As cameras may write them: `space` in the file, luma sampled h x v times as densely as chroma.
Bytes EncodedBySomebodyElse(const TestImage& image, J_COLOR_SPACE space, int h, int v) {
  jpeg_compress_struct info;
  jpeg_error_mgr error;
  info.err = jpeg_std_error(&error);
  jpeg_create_compress(&info);
  unsigned char* memory = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &memory, &size);
  const bool cmyk = space == JCS_CMYK;  // three of its inks are the image's colours, black is none
  info.image_width = static_cast<JDIMENSION>(image.width);
  info.image_height = static_cast<JDIMENSION>(image.height);
  info.input_components = cmyk ? 4 : 3;
  info.in_color_space = cmyk ? JCS_CMYK : JCS_RGB;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, 95, TRUE);
  jpeg_set_colorspace(&info, space);
  info.comp_info[0].h_samp_factor = h;
  info.comp_info[0].v_samp_factor = v;
  jpeg_start_compress(&info, TRUE);
  for (int row = 0; row < image.height; ++row) {
    Bytes pixels;
    for (int u = 0; u < image.width; ++u) {
      pixels.insert(pixels.end(), image.at(u, row), image.at(u, row) + 3);
      if (cmyk) pixels.push_back(0);
    }
    JSAMPROW rows[] = {pixels.data()};
    jpeg_write_scanlines(&info, rows, 1);
  }
  jpeg_finish_compress(&info);
  Bytes jpeg(memory, memory + size);
  jpeg_destroy_compress(&info);
  std::free(memory);
  return jpeg;
}

// The waves change their colour by up to 10 levels a pixel: chroma half a pixel beside its place
// fails.
TEST(JpegPlanes, ArePlanesOfTheDecodedPicture) {
  for (bool progressive : {false, true}) {
    for (const auto& [width, height] :
         {std::pair{160, 96}, {161, 97}, {17, 300}, {2, 2}, {1, 1}, {33, 8}}) {
      const TestImage image = WaveImage(width, height);
      const Bytes jpeg = Encoded(image, {.quality = 98, .progressive = progressive});
      JpegDecoder decoder;
      const auto planes = decoder.DecodeYuv420(jpeg);
      ASSERT_TRUE(planes) << planes.error().message;
      ASSERT_EQ(planes->width_px(), width);
      ASSERT_EQ(planes->height_px(), height);
      Yuv420Buffer buffer;
      const Yuv420View expected = buffer.View(width, height);
      Yuv420FromRgb(image.view(), expected);
      EXPECT_GT(PlanePsnr(planes->y, expected.y), 42.0) << width << " x " << height;
      EXPECT_GT(PlanePsnr(planes->cb, expected.cb), 42.0) << width << " x " << height;
      EXPECT_GT(PlanePsnr(planes->cr, expected.cr), 42.0) << width << " x " << height;
    }
  }
}

TEST(JpegPlanes, OtherSamplingsAndColoursGoThroughRgb) {
  const TestImage image = WaveImage(83, 61);
  struct Case {
    const char* name;
    J_COLOR_SPACE space;
    int h, v;
  };
  for (const Case& c :
       {Case{"4:4:4", JCS_YCbCr, 1, 1}, Case{"4:2:2", JCS_YCbCr, 2, 1},
        Case{"4:4:0", JCS_YCbCr, 1, 2}, Case{"4:1:1", JCS_YCbCr, 4, 1},
        Case{"4:1:0", JCS_YCbCr, 4, 2}, Case{"RGB", JCS_RGB, 1, 1},
        Case{"grey", JCS_GRAYSCALE, 1, 1}, Case{"grey 2 x 2", JCS_GRAYSCALE, 2, 2}}) {
    const Bytes jpeg = EncodedBySomebodyElse(image, c.space, c.h, c.v);
    JpegDecoder decoder, rgb_decoder;
    const auto planes = decoder.DecodeYuv420(jpeg);
    ASSERT_TRUE(planes) << c.name << planes.error().message;
    Yuv420Buffer buffer;
    const Yuv420View expected = buffer.View(image.width, image.height);
    Yuv420FromRgb(*rgb_decoder.Decode(jpeg), expected);
    EXPECT_GT(PlanePsnr(planes->y, expected.y), 90.0) << c.name;  // the very same
    EXPECT_GT(PlanePsnr(planes->cb, expected.cb), 90.0) << c.name;
    EXPECT_GT(PlanePsnr(planes->cr, expected.cr), 90.0) << c.name;
  }
  const auto inks = JpegDecoder().DecodeYuv420(EncodedBySomebodyElse(image, JCS_CMYK, 1, 1));
  ASSERT_FALSE(inks);
  EXPECT_NE(inks.error().message.find("4 colour components"), std::string::npos);
}

TEST(JpegPlanes, EncodeToThePictureThatRgbEncodesTo) {
  for (bool progressive : {false, true}) {
    for (const auto& [width, height] :
         {std::pair{160, 96}, {161, 97}, {17, 301}, {1, 1}, {40, 24}}) {
      const TestImage image = WaveImage(width, height);
      const JpegOptions options{.quality = 90, .progressive = progressive};
      Yuv420Buffer buffer;
      const Yuv420View planes = buffer.View(width, height);
      Yuv420FromRgb(image.view(), planes);
      JpegEncoder encoder;
      const auto jpeg = encoder.EncodeYuv420(planes, options);
      ASSERT_TRUE(jpeg) << jpeg.error().message;
      const Bytes from_rgb = Encoded(image, options);
      // One level of rounding in the chroma apart: the files must be as alike as that.
      EXPECT_NEAR(static_cast<double>(jpeg->size()), static_cast<double>(from_rgb.size()),
                  0.02 * static_cast<double>(from_rgb.size()) + 8);
      JpegDecoder one, two;
      const auto info = one.ReadInfo(*jpeg);
      EXPECT_EQ(info->progressive, progressive);
      EXPECT_GT(Psnr(*one.Decode(*jpeg), *two.Decode(from_rgb)), 45.0) << width << " x " << height;
    }
  }
}

TEST(JpegPlanes, BaselineHasItsRestartMarkers) {
  const TestImage image = WaveImage(200, 150);
  Yuv420Buffer buffer;
  const Yuv420View planes = buffer.View(200, 150);
  Yuv420FromRgb(image.view(), planes);
  JpegEncoder encoder;
  const auto jpeg = encoder.EncodeYuv420(planes, {});
  int restarts = 0;
  for (std::size_t i = 0; i + 1 < jpeg->size(); ++i)
    restarts += (*jpeg)[i] == 0xFF && (*jpeg)[i + 1] >= 0xD0 && (*jpeg)[i + 1] <= 0xD7;
  EXPECT_EQ(restarts, (150 + 15) / 16 - 1);
}

// What lies in the planes' margin must not get into the file.
TEST(JpegPlanes, SameSamplesSameBytesWhateverLiesBeyondThem) {
  const TestImage image = WaveImage(51, 37);
  JpegEncoder encoder;
  Bytes first;
  for (const std::uint8_t rubbish : Bytes{0, 99, 255}) {
    Yuv420Buffer buffer;
    const Yuv420View large = buffer.View(100, 100);
    std::memset(large.y.data, rubbish, buffer.capacity_bytes());
    const Yuv420View planes = buffer.View(51, 37);
    Yuv420FromRgb(image.view(), planes);
    for (const PlaneView& plane : {planes.y, planes.cb, planes.cr}) {
      for (int v = 0; v < plane.height_px; ++v) plane.row(v)[plane.width_px] = rubbish;
    }
    const auto jpeg = encoder.EncodeYuv420(planes, {});
    if (first.empty()) first.assign(jpeg->begin(), jpeg->end());
    EXPECT_TRUE(std::equal(first.begin(), first.end(), jpeg->begin(), jpeg->end()));
  }
}

TEST(JpegPlanes, AFormerPictureLeavesNoTrace) {
  const Bytes jpeg = Encoded(WaveImage(51, 37));
  JpegDecoder fresh, used;
  (void)used.DecodeYuv420(Encoded(NoiseImage(120, 90, 7)));
  (void)used.Decode(jpeg);
  const auto a = fresh.DecodeYuv420(jpeg), b = used.DecodeYuv420(jpeg);
  for (const auto& [one, two] : {std::pair{a->y, b->y}, {a->cb, b->cb}, {a->cr, b->cr}}) {
    // Whole blocks, margin and all: the reduction to a preview takes it in.
    for (int v = 0; v < (one.height_px + 7) / 8 * 8; ++v) {
      const std::ptrdiff_t whole = (one.width_px + 7) / 8 * 8;
      ASSERT_TRUE(std::equal(one.row(v), one.row(v) + whole, two.row(v)));
    }
  }
}

TEST(JpegPlanes, DamageIsWhatItIsToRgb) {
  const Bytes good = Encoded(WaveImage(64, 48));
  JpegDecoder planes, rgb;
  std::mt19937 random(5);
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    Bytes spoiled = good;
    if (i % 3 == 0) spoiled.resize(random() % good.size());
    for (int k = 0; k < 3 && !spoiled.empty(); ++k)
      spoiled[random() % spoiled.size()] = static_cast<std::uint8_t>(random());
    const JpegDecodeOptions options{.accept_damage = i % 2 == 0, .max_pixels = 1'000'000};
    const auto a = planes.DecodeYuv420(spoiled, options);
    const auto b = rgb.Decode(spoiled, options);
    ASSERT_EQ(a.has_value(), b.has_value()) << i;
    refused += !a;
    if (!a) {
      EXPECT_EQ(a.error().code, b.error().code);
      EXPECT_EQ(a.error().message, b.error().message);
    } else {
      EXPECT_EQ(a->width_px(), b->width_px);
      EXPECT_EQ(planes.warnings(), rgb.warnings());
    }
  }
  EXPECT_GT(refused, 300);
  EXPECT_LT(refused, 2900);
  EXPECT_TRUE(planes.DecodeYuv420(good));
}

TEST(JpegPlanes, BuffersDoNotGrowAfterTheFirstPicture) {
  const Bytes jpeg = Encoded(NoiseImage(256, 128, 6));
  const Bytes smaller = Encoded(NoiseImage(255, 120, 6));
  JpegDecoder decoder;
  const auto first = decoder.DecodeYuv420(jpeg);
  const void* const address = first->y.data;
  const std::size_t bytes = decoder.buffer_bytes();
  for (const Bytes& next : {smaller, jpeg, smaller}) {
    const auto again = decoder.DecodeYuv420(next);
    ASSERT_TRUE(again);
    EXPECT_EQ(again->y.data, address);
  }
  EXPECT_EQ(decoder.buffer_bytes(), bytes);
}

TEST(JpegPlanes, EncoderRefusesWhatCannotBe) {
  JpegEncoder encoder;
  Yuv420Buffer buffer;
  const Yuv420View planes = buffer.View(8, 8);
  EXPECT_FALSE(encoder.EncodeYuv420({}, {}));
  EXPECT_FALSE(encoder.EncodeYuv420(planes, {.quality = 0}));
  Yuv420View wide = planes;
  wide.y.width_px = 70000;
  const auto refused = encoder.EncodeYuv420(wide, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, core::ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace kawara::vision
