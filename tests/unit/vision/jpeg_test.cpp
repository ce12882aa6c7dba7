#include "vision/jpeg.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "vision_test_support.hpp"

namespace kawara::vision {
namespace {

std::vector<std::uint8_t> Encoded(const TestImage& image, const JpegOptions& options = {}) {
  JpegEncoder encoder;
  const auto bytes = encoder.Encode(image.view(), options);
  EXPECT_TRUE(bytes);
  return {bytes->begin(), bytes->end()};
}

int CountMarkers(const std::vector<std::uint8_t>& jpeg, std::uint8_t first, std::uint8_t last) {
  int count = 0;
  for (std::size_t i = 0; i + 1 < jpeg.size(); ++i)
    count += jpeg[i] == 0xFF && jpeg[i + 1] >= first && jpeg[i + 1] <= last;
  return count;
}

TEST(Jpeg, RoundTripKeepsThePicture) {
  for (bool progressive : {false, true}) {
    for (const auto& [width, height] :
         {std::pair{160, 96}, std::pair{161, 97}, std::pair{1, 1}, std::pair{17, 300}}) {
      TestImage image(width, height);
      for (int v = 0; v < height; ++v) {
        for (int u = 0; u < width; ++u) {  // grey waves: 4:2:0 has no say in them
          const auto level = static_cast<std::uint8_t>(
              std::lround(127 + 60 * std::sin(0.2 * u) + 50 * std::cos(0.15 * v)));
          std::fill_n(image.at(u, v), 3, level);
        }
      }
      const auto jpeg = Encoded(image, {.quality = 95, .progressive = progressive});
      JpegDecoder decoder;
      const auto info = decoder.ReadInfo(jpeg);
      ASSERT_TRUE(info);
      EXPECT_EQ(info->progressive, progressive);
      const auto back = decoder.Decode(jpeg);
      ASSERT_TRUE(back) << back.error().message;
      ASSERT_EQ(back->width_px, width);
      ASSERT_EQ(back->height_px, height);
      EXPECT_GT(Psnr(image.view(), *back), 42.0);
    }
  }
}

TEST(Jpeg, BaselineHasARestartMarkerAfterEveryRowOfBlocksButTheLast) {
  const TestImage image = WaveImage(200, 160);
  EXPECT_EQ(CountMarkers(Encoded(image), 0xD0, 0xD7), 160 / 16 - 1);
  EXPECT_EQ(CountMarkers(Encoded(image, {.progressive = true}), 0xD0, 0xD7), 0);
}

TEST(Jpeg, AHoleInABaselinePictureCostsOnlyTheRowsItHit) {
  const TestImage image = WaveImage(320, 320);
  std::vector<std::uint8_t> jpeg = Encoded(image);
  JpegDecoder decoder;
  const TestImage whole(*decoder.Decode(jpeg));
  const std::size_t middle = jpeg.size() / 2;
  for (std::size_t i = middle; i < middle + 40; ++i)
    jpeg[i] = 0x55;  // restart markers elsewhere stay
  EXPECT_FALSE(decoder.Decode(jpeg)) << "damage must not pass for a good picture";
  const auto damaged = decoder.Decode(jpeg, {.accept_damage = true});
  ASSERT_TRUE(damaged);
  EXPECT_GT(decoder.warnings(), 0);
  int bad_rows = 0;
  for (int v = 0; v < 320; ++v)
    bad_rows += !std::equal(whole.at(0, v), whole.at(0, v) + 960, damaged->row(v));
  EXPECT_GT(bad_rows, 0);
  EXPECT_LE(bad_rows, 3 * 16 + 2);
}

// The reduced picture must be the full one averaged over its pixels, in the same place: not
// shifted.
TEST(Jpeg, ScaledDecodeIsTheSamePictureSmaller) {
  const TestImage image = WaveImage(640, 320);
  const auto jpeg = Encoded(image, {.quality = 95});
  JpegDecoder decoder;
  for (int eighths : {1, 2, 4}) {
    const auto small = decoder.Decode(jpeg, {.scale_eighths = eighths});
    ASSERT_TRUE(small);
    ASSERT_EQ(small->width_px, 80 * eighths);
    ASSERT_EQ(small->height_px, 40 * eighths);
    const int step = 8 / eighths;
    TestImage mean(small->width_px, small->height_px);
    for (int v = 0; v < mean.height; ++v) {
      for (int u = 0; u < mean.width; ++u) {
        for (int c = 0; c < 3; ++c) {
          int sum = 0;
          for (int y = 0; y < step; ++y) {
            for (int x = 0; x < step; ++x) sum += image.at(u * step + x, v * step + y)[c];
          }
          mean.at(u, v)[c] = static_cast<std::uint8_t>(sum / (step * step));
        }
      }
    }
    EXPECT_GT(Psnr(mean.view(), *small), 30.0) << eighths;
  }
}

TEST(Jpeg, ScaleEighthsIsTheSmallestThatSuffices) {
  EXPECT_EQ(ScaleEighthsFor(5376, 512), 1);
  EXPECT_EQ(ScaleEighthsFor(4096, 512), 1);
  EXPECT_EQ(ScaleEighthsFor(3072, 512), 2);
  EXPECT_EQ(ScaleEighthsFor(1024, 1024), 8);
  EXPECT_EQ(ScaleEighthsFor(100, 1024), 8);
}

TEST(Jpeg, EveryTruncationIsAnError) {
  for (bool progressive : {false, true}) {
    const auto jpeg = Encoded(WaveImage(64, 48), {.progressive = progressive});
    JpegDecoder decoder;
    for (std::size_t length = 0; length + 2 < jpeg.size(); length += 7) {
      const auto picture = decoder.Decode(std::span(jpeg).first(length));
      ASSERT_FALSE(picture) << length << " of " << jpeg.size();
      EXPECT_EQ(picture.error().code, core::ErrorCode::kFormat);
    }
    EXPECT_TRUE(decoder.Decode(jpeg)) << "the decoder must survive its errors";
  }
}

TEST(Jpeg, SpoiledBytesNeverCrash) {
  const auto jpeg = Encoded(WaveImage(64, 48));
  JpegDecoder decoder;
  std::mt19937 random(5);
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    auto spoiled = jpeg;
    for (int k = 0; k < 3; ++k)
      spoiled[random() % spoiled.size()] = static_cast<std::uint8_t>(random());
    refused += !decoder.Decode(spoiled, {.accept_damage = i % 2 == 0, .max_pixels = 1'000'000});
  }
  EXPECT_GT(refused, 100);
  EXPECT_TRUE(decoder.Decode(jpeg));
}

// A 600-byte file that claims 65000 x 65000 px, and one of plausible size but without the bytes for
// it.
TEST(Jpeg, AbsurdSizesAreRefusedBeforeMemoryIsTaken) {
  auto jpeg = Encoded(WaveImage(64, 48));
  constexpr std::uint8_t kFrameHeader[] = {0xFF, 0xC0};
  const auto frame =
      std::search(jpeg.begin(), jpeg.end(), std::begin(kFrameHeader), std::end(kFrameHeader));
  ASSERT_NE(frame, jpeg.end());
  const auto set_size = [&](int width, int height) {
    frame[5] = static_cast<std::uint8_t>(height >> 8);
    frame[6] = static_cast<std::uint8_t>(height);
    frame[7] = static_cast<std::uint8_t>(width >> 8);
    frame[8] = static_cast<std::uint8_t>(width);
  };
  JpegDecoder decoder;
  set_size(65000, 65000);
  EXPECT_NE(decoder.Decode(jpeg).error().message.find("65000 x 65000"), std::string::npos);
  set_size(9000, 9000);
  EXPECT_NE(decoder.Decode(jpeg).error().message.find("too short"), std::string::npos);
  EXPECT_EQ(decoder.buffer_bytes(), 0u);
}

TEST(Jpeg, BuffersDoNotGrowAfterTheFirstPicture) {
  const TestImage image = NoiseImage(256, 128, 6);
  JpegEncoder encoder;
  JpegDecoder decoder;
  const auto first = encoder.Encode(image.view(), {.quality = 100});
  ASSERT_TRUE(first);
  const void* const address = first->data();
  ASSERT_TRUE(decoder.Decode(*first));
  const std::size_t encoder_bytes = encoder.buffer_bytes(), decoder_bytes = decoder.buffer_bytes();
  for (int i = 0; i < 5; ++i) {
    const auto jpeg = encoder.Encode(image.view(), {.quality = 100 - i, .progressive = i % 2 == 1});
    ASSERT_TRUE(jpeg);
    EXPECT_EQ(jpeg->data(), address);
    ASSERT_TRUE(decoder.Decode(*jpeg));
  }
  EXPECT_EQ(encoder.buffer_bytes(), encoder_bytes);
  EXPECT_EQ(decoder.buffer_bytes(), decoder_bytes);
}

TEST(Jpeg, EncoderRefusesWhatCannotBe) {
  JpegEncoder encoder;
  const TestImage image = WaveImage(8, 8);
  EXPECT_FALSE(encoder.Encode({}, {}));
  EXPECT_FALSE(encoder.Encode({image.bytes.data(), 70000, 1}, {}));
  EXPECT_FALSE(encoder.Encode(image.view(), {.quality = 0}));
  EXPECT_FALSE(encoder.Encode(image.view(), {.quality = 101}));
  EXPECT_TRUE(encoder.Encode(image.view(), {.quality = 100}));
}

TEST(Jpeg, SameInputSameBytesWhateverCameBefore) {
  const TestImage image = WaveImage(64, 64);
  JpegEncoder encoder;
  const auto first = Encoded(image);
  (void)encoder.Encode(NoiseImage(200, 200, 1).view(), {.quality = 30, .progressive = true});
  const auto later = *encoder.Encode(image.view(), {});
  EXPECT_TRUE(std::equal(first.begin(), first.end(), later.begin(), later.end()));
  EXPECT_TRUE(JpegDecoder().Decode(later));
}

TEST(Jpeg, DecodesARealCamerasPicture) {
  JpegDecoder decoder;
  const auto jpeg = ReadTestFile("data/panorama/R0014760_3072.jpg");
  const auto picture = decoder.Decode(jpeg, {.scale_eighths = 2});
  ASSERT_TRUE(picture);
  EXPECT_EQ(picture->width_px, 768);
  const std::uint8_t* sky = picture->row(20) + 3 * 500;
  const std::uint8_t* grass = picture->row(240) + 3 * 384;
  EXPECT_GT(sky[2], 200);
  EXPECT_GT(grass[1], grass[2] + 20);
}

}  // namespace
}  // namespace kawara::vision
