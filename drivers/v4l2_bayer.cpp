#include "drivers/v4l2_bayer.hpp"

#include <linux/videodev2.h>

#include <array>
#include <cstddef>

namespace kawara::drivers {
namespace {

/// The index beside `at`, mirrored where that is outside.
std::int64_t Before(std::int64_t at) { return at > 0 ? at - 1 : 1; }
std::int64_t After(std::int64_t at, std::int64_t size) { return at + 1 < size ? at + 1 : at - 1; }

std::uint8_t Mean(int a, int b) { return static_cast<std::uint8_t>((a + b + 1) / 2); }
std::uint8_t Mean(int a, int b, int c, int d) {
  return static_cast<std::uint8_t>((a + b + c + d + 2) / 4);
}

/// Where in the 2 x 2 cell red sits: its column, its row.
std::array<std::int64_t, 2> PlaceOfRed(std::uint32_t fourcc) {
  switch (fourcc) {
    case V4L2_PIX_FMT_SRGGB8:
      return {0, 0};
    case V4L2_PIX_FMT_SGRBG8:
      return {1, 0};
    case V4L2_PIX_FMT_SGBRG8:
      return {0, 1};
    default:  // V4L2_PIX_FMT_SBGGR8
      return {1, 1};
  }
}

}  // namespace

void RgbFromBayer(const V4l2PictureFormat& format, const std::uint8_t* from, std::uint8_t* to) {
  const std::int64_t width = format.width_px, height = format.height_px;
  const std::int64_t stride = format.stride_bytes;
  const auto [red_x, red_y] = PlaceOfRed(format.fourcc);
  for (std::int64_t y = 0; y < height; ++y) {
    const std::uint8_t* const above = from + Before(y) * stride;
    const std::uint8_t* const row = from + y * stride;
    const std::uint8_t* const below = from + After(y, height) * stride;
    const bool red_row = y % 2 == red_y;
    for (std::int64_t x = 0; x < width; ++x, to += 3) {
      const std::int64_t l = Before(x), r = After(x, width);
      const bool red_column = x % 2 == red_x;
      if (red_row != red_column) {  // green: one colour beside it, the other above and below
        const std::uint8_t beside = Mean(row[l], row[r]);
        const std::uint8_t vertical = Mean(above[x], below[x]);
        to[0] = red_row ? beside : vertical;
        to[1] = row[x];
        to[2] = red_row ? vertical : beside;
      } else {
        const std::uint8_t opposite = Mean(above[l], above[r], below[l], below[r]);
        to[0] = red_row ? row[x] : opposite;
        to[1] = Mean(row[l], row[r], above[x], below[x]);
        to[2] = red_row ? opposite : row[x];
      }
    }
  }
}

}  // namespace kawara::drivers
