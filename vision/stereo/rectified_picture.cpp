#include "vision/stereo/rectified_picture.hpp"

namespace kawara::vision {

void Halve(const RectifiedPicture& picture, RectifiedPicture& half) {
  half.Resize(picture.grid.Halved());
  const auto width = static_cast<std::size_t>(half.grid.width_px);
  for (int y = 0; y < half.grid.height_px; ++y) {
    const std::uint32_t* upper = picture.row(2 * y);
    const std::uint32_t* lower = picture.row(2 * y + 1);
    std::uint32_t* out = half.row(y);
    for (std::size_t x = 0; x < width; ++x) {
      const std::uint32_t a = upper[2 * x], b = upper[2 * x + 1], c = lower[2 * x],
                          d = lower[2 * x + 1];
      // Two channels at a time, 16 bits each: sums of four bytes and the half for rounding fit.
      constexpr std::uint32_t kPairs = 0x00FF00FFU, kHalves = 0x00020002U;
      const std::uint32_t even =
          (a & kPairs) + (b & kPairs) + (c & kPairs) + (d & kPairs) + kHalves;
      const std::uint32_t odd =
          (a >> 8 & kPairs) + (b >> 8 & kPairs) + (c >> 8 & kPairs) + (d >> 8 & kPairs) + kHalves;
      const std::uint32_t mean = (even >> 2 & kPairs) | (odd >> 2 & kPairs) << 8;
      out[x] = (a & b & c & d) >= 0xFF000000U ? mean : 0U;
    }
  }
}

}  // namespace kawara::vision
