// MJPEG frames as cameras send them, made whole by the driver and read by our own decoder: the two
// rooms do not know each other.
#include "drivers/motion_jpeg.hpp"

#include <gtest/gtest.h>

#include <random>

#include "vision/jpeg.hpp"

namespace kawara::onboard {
namespace {

std::vector<std::uint8_t> Picture(bool progressive = false) {
  std::vector<std::uint8_t> rgb;
  std::mt19937 dice(1);
  for (int i = 0; i < 96 * 64 * 3; ++i) rgb.push_back(static_cast<std::uint8_t>(dice() % 256));
  vision::JpegEncoder encoder;
  const auto jpeg = encoder.Encode(vision::ConstImageView{rgb.data(), 96, 64},
                                   {.quality = 80, .progressive = progressive});
  return {jpeg->begin(), jpeg->end()};
}

/// The segments of a header with this marker taken out; how many there were.
int TakeOut(std::vector<std::uint8_t>& jpeg, std::uint8_t marker) {
  int taken = 0;
  for (std::size_t at = 2; at + 4 < jpeg.size() && jpeg[at] == 0xFF && jpeg[at + 1] != 0xDA;) {
    const std::size_t length = 2 + ((std::size_t{jpeg[at + 2]} << 8) | jpeg[at + 3]);
    if (jpeg[at + 1] == marker) {
      jpeg.erase(jpeg.begin() + static_cast<std::ptrdiff_t>(at),
                 jpeg.begin() + static_cast<std::ptrdiff_t>(at + length));
      ++taken;
    } else {
      at += length;
    }
  }
  return taken;
}

std::vector<std::uint8_t> Decoded(const std::vector<std::uint8_t>& jpeg) {
  vision::JpegDecoder decoder;
  const auto view = decoder.Decode(jpeg);
  EXPECT_TRUE(view) << view.error().message;
  EXPECT_EQ(decoder.warnings(), 0);
  if (!view) return {};
  return {view->data, view->data + view->size_bytes()};
}

bool HasTables(const std::vector<std::uint8_t>& jpeg) {
  std::vector<std::uint8_t> copy = jpeg;
  return TakeOut(copy, 0xC4) > 0;
}

TEST(MotionJpeg, WholeFileStaysAsItIs) {
  for (const bool progressive : {false, true}) {
    const auto jpeg = Picture(progressive);
    const auto read = drivers::ReadMotionJpeg(jpeg);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->bytes, jpeg);
    EXPECT_EQ(read->width_px, 96U);
    EXPECT_EQ(read->height_px, 64U);
  }
}

TEST(MotionJpeg, MissingHuffmanTablesArePutIn) {
  const auto whole = Picture();
  auto frame = whole;
  ASSERT_GT(TakeOut(frame, 0xC4), 0);
  const auto read = drivers::ReadMotionJpeg(frame);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(HasTables(read->bytes));
  EXPECT_EQ(Decoded(read->bytes), Decoded(whole));
}

TEST(MotionJpeg, PaddingIsLeftOut) {
  const auto whole = Picture();
  auto frame = whole;
  frame.resize(frame.size() + 5000);
  EXPECT_EQ(drivers::ReadMotionJpeg(frame)->bytes, whole);
}

TEST(MotionJpeg, EveryCutIsNoticed) {
  const auto whole = Picture();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto cut = drivers::ReadMotionJpeg(std::span(whole).first(size));
    ASSERT_FALSE(cut) << size;
    EXPECT_EQ(cut.error().code, core::ErrorCode::kFormat);
    // With the zeros of an unfinished transfer behind it.
    std::vector<std::uint8_t> padded(whole.begin(),
                                     whole.begin() + static_cast<std::ptrdiff_t>(size));
    padded.resize(whole.size() + 100);
    ASSERT_FALSE(drivers::ReadMotionJpeg(padded)) << size;
  }
}

}  // namespace
}  // namespace kawara::onboard
