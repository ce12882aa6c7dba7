#include "drivers/v4l2_bayer.hpp"

#include <linux/videodev2.h>

#include <array>

namespace kawara::drivers {
namespace {

struct Raster {
  const std::uint8_t* bytes;
  std::int64_t width, height, stride;

  /// Mean of the samples at these offsets that are inside. At least one always is.
  template <std::size_t N>
  std::uint8_t Mean(std::int64_t x, std::int64_t y,
                    const std::array<std::array<std::int8_t, 2>, N>& offsets) const {
    int sum = 0, count = 0;
    for (const auto& [dx, dy] : offsets) {
      const std::int64_t u = x + dx, v = y + dy;
      if (u < 0 || v < 0 || u >= width || v >= height) continue;
      sum += bytes[v * stride + u];
      ++count;
    }
    return static_cast<std::uint8_t>((sum + count / 2) / count);
  }
};

constexpr std::array<std::array<std::int8_t, 2>, 4> kCross{{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
constexpr std::array<std::array<std::int8_t, 2>, 4> kDiagonal{{{-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};
constexpr std::array<std::array<std::int8_t, 2>, 2> kBeside{{{-1, 0}, {1, 0}}};
constexpr std::array<std::array<std::int8_t, 2>, 2> kAboveBelow{{{0, -1}, {0, 1}}};

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
  const Raster raster{from, format.width_px, format.height_px, format.stride_bytes};
  const auto [red_x, red_y] = PlaceOfRed(format.fourcc);
  for (std::int64_t y = 0; y < raster.height; ++y) {
    const bool red_row = y % 2 == red_y;
    for (std::int64_t x = 0; x < raster.width; ++x, to += 3) {
      const bool red_column = x % 2 == red_x;
      const std::uint8_t own = from[y * raster.stride + x];
      if (red_row != red_column) {  // green: one colour beside it, the other above and below
        const std::uint8_t beside = raster.Mean(x, y, kBeside);
        const std::uint8_t above_below = raster.Mean(x, y, kAboveBelow);
        to[0] = red_row ? beside : above_below;
        to[1] = own;
        to[2] = red_row ? above_below : beside;
      } else {
        const std::uint8_t opposite = raster.Mean(x, y, kDiagonal);
        to[0] = red_row ? own : opposite;
        to[1] = raster.Mean(x, y, kCross);
        to[2] = red_row ? opposite : own;
      }
    }
  }
}

}  // namespace kawara::drivers
