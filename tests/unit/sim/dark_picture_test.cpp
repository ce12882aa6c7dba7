#include "sim/camera/dark_picture.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "vision/jpeg.hpp"

namespace kawara::sim {
namespace {

TEST(DarkPicture, IsAJpegOfTheSameSizeAndBlack) {
  const auto dark = DarkPicture({.width = 320, .height = 240, .jpeg = {1, 2, 3}});
  ASSERT_TRUE(dark) << dark.error().message;
  EXPECT_EQ(dark->width, 320U);
  EXPECT_EQ(dark->height, 240U);
  vision::JpegDecoder decoder;
  const auto image = decoder.Decode(dark->jpeg);
  ASSERT_TRUE(image) << image.error().message;
  ASSERT_EQ(image->width_px, 320);
  ASSERT_EQ(image->height_px, 240);
  EXPECT_LT(*std::max_element(image->data, image->data + image->size_bytes()), 16);
}

}  // namespace
}  // namespace kawara::sim
