#include "vision/png.hpp"

#include <gtest/gtest.h>
#include <zlib.h>

#include <array>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "vision_test_support.hpp"

/// OpenCV's PNGs for our readers, our PNGs for its reader: two ways through libpng.
namespace kawara::vision {
namespace {

using Bytes = std::vector<std::uint8_t>;
using core::ErrorCode;

Grey16Picture Ramp(int width_px, int height_px) {
  Grey16Picture picture{{}, width_px, height_px};
  picture.level.resize(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px));
  std::iota(picture.level.begin(), picture.level.end(), std::uint16_t{65500});  // and over the end
  return picture;
}

Bytes ByOpenCv(const cv::Mat& picture) {
  Bytes bytes;
  EXPECT_TRUE(cv::imencode(".png", picture, bytes));
  return bytes;
}

void AppendBigEndian(Bytes& bytes, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<std::uint8_t>(value >> shift));
  }
}

void AppendChunk(Bytes& bytes, const std::string& type, const Bytes& data) {
  AppendBigEndian(bytes, static_cast<std::uint32_t>(data.size()));
  Bytes body(type.begin(), type.end());
  body.insert(body.end(), data.begin(), data.end());
  bytes.insert(bytes.end(), body.begin(), body.end());
  AppendBigEndian(
      bytes, static_cast<std::uint32_t>(crc32(0, body.data(), static_cast<unsigned>(body.size()))));
}

/// A file by hand: header, chunks before the pixels, rows with their filter bytes.
Bytes ByHand(std::uint32_t width_px, std::uint32_t height_px, int bits, int colour_type,
             const std::vector<std::pair<std::string, Bytes>>& chunks, const Bytes& rows) {
  Bytes file = {0x89, 'P', 'N', 'G', 0x0D, 0x0A, 0x1A, 0x0A};
  Bytes header;
  AppendBigEndian(header, width_px);
  AppendBigEndian(header, height_px);
  header.insert(header.end(),
                {static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(colour_type), 0, 0, 0});
  AppendChunk(file, "IHDR", header);
  for (const auto& [type, data] : chunks) AppendChunk(file, type, data);
  Bytes packed(compressBound(rows.size()));
  uLongf size = packed.size();
  EXPECT_EQ(compress(packed.data(), &size, rows.data(), rows.size()), Z_OK);
  packed.resize(size);
  AppendChunk(file, "IDAT", packed);
  AppendChunk(file, "IEND", {});
  return file;
}

TEST(Png, ColoursAreWrittenAsTheyAre) {
  const TestImage image = NoiseImage(37, 11, 1);
  for (const int effort : {kPngFast, kPngSmall}) {
    const auto file = EncodePng(image.view(), effort);
    ASSERT_TRUE(file);
    const cv::Mat read = cv::imdecode(*file, cv::IMREAD_UNCHANGED);
    ASSERT_EQ(read.type(), CV_8UC3);
    for (int v = 0; v < 11; ++v) {
      for (int u = 0; u < 37; ++u) {
        for (int c = 0; c < 3; ++c) {
          ASSERT_EQ(read.at<cv::Vec3b>(v, u)[2 - c], image.at(u, v)[c]);
        }
      }
    }
    const auto back = DecodePng(*file);
    ASSERT_TRUE(back);
    EXPECT_EQ(back->rgb, image.bytes);
  }
}

TEST(Png, NumbersOfSixteenBitsAreWrittenAsTheyAre) {
  const Grey16Picture picture = Ramp(300, 7);
  const auto file = EncodePng(picture, kPngFast);
  ASSERT_TRUE(file);
  const cv::Mat read = cv::imdecode(*file, cv::IMREAD_UNCHANGED);
  ASSERT_EQ(read.type(), CV_16UC1);
  EXPECT_EQ(std::vector<std::uint16_t>(read.begin<std::uint16_t>(), read.end<std::uint16_t>()),
            picture.level);
  const auto back = DecodeGrey16Png(*file);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->level, picture.level);
  EXPECT_EQ(back->width_px, 300);
  EXPECT_EQ(back->height_px, 7);
}

TEST(Png, EveryKindIsReadAsColours) {
  const Bytes palette{1, 2, 3, 250, 240, 230};
  const Bytes half{0, 128};  // the second colour is half transparent, which changes nothing
  struct Case {
    const char* name;
    Bytes file;
    Bytes rgb;  ///< of two pixels in a row
  };
  for (const Case& c : std::vector<Case>{
           {"grey", ByHand(2, 1, 8, 0, {}, {0, 7, 200}), {7, 7, 7, 200, 200, 200}},
           {"grey of 16 bits",
            ByHand(2, 1, 16, 0, {}, {0, 7, 255, 200, 1}),
            {7, 7, 7, 200, 200, 200}},
           {"grey of 12 bits in 16",
            ByHand(2, 1, 16, 0, {}, {0, 0x0F, 0xFF, 0x01, 0x20}),
            {255, 255, 255, 18, 18, 18}},
           {"colours of 10 bits in 16",
            ByHand(2, 1, 16, 2, {}, {0, 0x03, 0xFF, 0x01, 0x00, 0, 8, 0, 0, 0, 4, 0x02, 0x00}),
            {255, 64, 2, 0, 1, 128}},
           {"dark, but of 16 bits as it says",
            ByHand(2, 1, 16, 0, {{"sBIT", {16}}}, {0, 0x0F, 0xFF, 0x01, 0x20}),
            {15, 15, 15, 1, 1, 1}},
           {"grey of 1 bit", ByHand(2, 1, 1, 0, {}, {0, 0x40}), {0, 0, 0, 255, 255, 255}},
           {"palette",
            ByHand(2, 1, 1, 3, {{"PLTE", palette}}, {0, 0x40}),
            {1, 2, 3, 250, 240, 230}},
           {"palette with transparency",
            ByHand(2, 1, 8, 3, {{"PLTE", palette}, {"tRNS", half}}, {0, 1, 0}),
            {250, 240, 230, 1, 2, 3}},
           {"grey with transparency",
            ByHand(2, 1, 8, 4, {}, {0, 7, 9, 200, 0}),
            {7, 7, 7, 200, 200, 200}},
           {"colours with transparency",
            ByHand(2, 1, 8, 6, {}, {0, 1, 2, 3, 0, 4, 5, 6, 255}),
            {1, 2, 3, 4, 5, 6}},
           {"a gamma, which is not followed",
            ByHand(2, 1, 8, 2, {{"gAMA", {0, 1, 0x86, 0xA0}}}, {0, 1, 2, 3, 4, 5, 6}),
            {1, 2, 3, 4, 5, 6}}}) {
    SCOPED_TRACE(c.name);
    const auto picture = DecodePng(c.file);
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_EQ(picture->width_px, 2);
    EXPECT_EQ(picture->height_px, 1);
    EXPECT_EQ(picture->rgb, c.rgb);
  }
}

TEST(Png, OnlyGreyOfSixteenBitsIsNumbers) {
  EXPECT_TRUE(DecodeGrey16Png(ByOpenCv(cv::Mat(3, 4, CV_16UC1, cv::Scalar(77)))));
  for (const int type : {CV_8UC1, CV_8UC3, CV_16UC3, CV_16UC4}) {
    const auto picture = DecodeGrey16Png(ByOpenCv(cv::Mat(3, 4, type, cv::Scalar::all(77))));
    ASSERT_FALSE(picture) << type;
    EXPECT_EQ(picture.error().code, ErrorCode::kFormat);
  }
}

TEST(Png, DamageIsAnErrorWhereverItIs) {
  const auto whole = EncodePng(NoiseImage(40, 30, 2).view(), kPngFast);
  ASSERT_TRUE(whole);
  for (std::size_t size = 0; size < whole->size(); size += 7) {
    EXPECT_FALSE(DecodePng(std::span(*whole).first(size))) << size;
  }
  for (std::size_t at = 0; at < whole->size(); at += 13) {
    Bytes broken = *whole;
    broken[at] ^= 0x10;
    const auto picture = DecodePng(broken);
    ASSERT_FALSE(picture) << "byte " << at;
    EXPECT_EQ(picture.error().code, ErrorCode::kFormat);
  }
}

TEST(Png, AFewBytesThatAskForMuchAreRefusedAtOnce) {
  for (const auto& [side, limit] : {std::pair<std::uint32_t, std::int64_t>{9000, kMaxPngPixels},
                                    {20000, kMaxPngPixels},
                                    {101, 10000}}) {
    const auto picture = DecodePng(ByHand(side, side, 8, 2, {}, {0, 1, 2, 3}), limit);
    ASSERT_FALSE(picture) << side;
    EXPECT_NE(picture.error().message.find(std::to_string(side)), std::string::npos);
  }
}

TEST(Png, WhatIsNoPictureIsNotWritten) {
  EXPECT_FALSE(EncodePng(ConstImageView{}, kPngFast));
  EXPECT_FALSE(EncodePng(Grey16Picture{}, kPngFast));
  EXPECT_FALSE(EncodePng(Grey16Picture{{1, 2, 3}, 2, 2}, kPngFast));
}

}  // namespace
}  // namespace kawara::vision
