#include "vision/stereo/contrast_plane.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::vision {
namespace {

/// Half width of the neighbourhood, half-size pixels.
constexpr int kRadius = 4;
/// Contrast below which a place counts as plain: two grey levels, in sums of twelve bytes.
constexpr float kPlain = 24.0F;
/// White noise has as much variance as half the mean squared difference of neighbours; what the
/// world is made of has more, being rougher in the large than in the small. Interpolation has made
/// neighbours' noise a little alike.
constexpr float kNoiseRatio = 1.2F;
/// Contrast above which a place is never plain, however fine its grain: three grey levels.
constexpr float kNeverPlain = 36.0F;
/// Levels of a deviation of one.
constexpr float kGain = 42.0F;

}  // namespace

void ContrastMaker::HalveBrightness(const RectifiedPicture& picture, ContrastPlane& plane) {
  for (int y = 0; y < plane.height_px; ++y) {
    const std::uint32_t* upper = picture.row(2 * y);
    const std::uint32_t* lower = picture.row(2 * y + 1);
    const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(plane.width_px);
    std::uint16_t* brightness = brightness_.data() + at;
    std::uint8_t* seen = plane.seen.data() + at;
    for (int x = 0; x < plane.width_px; ++x) {
      const std::uint32_t a = upper[2 * x], b = upper[2 * x + 1], c = lower[2 * x],
                          d = lower[2 * x + 1];
      constexpr std::uint32_t kRedBlue = 0x00FF00FF, kGreen = 0x000000FF;
      const std::uint32_t red_blue =
          (a & kRedBlue) + (b & kRedBlue) + (c & kRedBlue) + (d & kRedBlue);
      const std::uint32_t green =
          (a >> 8 & kGreen) + (b >> 8 & kGreen) + (c >> 8 & kGreen) + (d >> 8 & kGreen);
      const bool all = (a & b & c & d) >= 0xFF000000U;
      brightness[x] =
          all ? static_cast<std::uint16_t>((red_blue & 0xFFFF) + (red_blue >> 16) + green) : 0;
      seen[x] = all ? 255 : 0;
    }
  }
}

void ContrastMaker::Make(const RectifiedPicture& picture, ContrastPlane& plane) {
  const int width = picture.grid.width_px / 2, height = picture.grid.height_px / 2;
  const auto columns = static_cast<std::size_t>(width);
  plane.width_px = width;
  plane.height_px = height;
  const std::size_t pixels = columns * static_cast<std::size_t>(height);
  plane.level.resize(pixels);
  plane.seen.resize(pixels);
  plane.plain.assign(pixels, 1);
  brightness_.resize(pixels);
  HalveBrightness(picture, plane);

  sum_.assign(columns + 1, 0);
  square_sum_.assign(columns + 1, 0);
  count_.assign(columns + 1, 0);
  step_sum_.assign(columns + 1, 0);
  const auto add_row = [&](int y, int sign) {
    if (y < 0 || y >= height) return;
    const std::uint16_t* brightness = brightness_.data() + static_cast<std::size_t>(y) * columns;
    const std::uint8_t* seen = plane.seen.data() + static_cast<std::size_t>(y) * columns;
    // The last row and column have their neighbours on the other side.
    const std::uint16_t* below = y + 1 < height ? brightness + columns : brightness - columns;
    const std::uint8_t* seen_below = y + 1 < height ? seen + columns : seen - columns;
    for (std::size_t x = 0; x < columns; ++x) {
      const std::int32_t value = brightness[x];
      const std::size_t beside = x + 1 < columns ? x + 1 : x - 1;
      const std::int32_t right = (seen[beside] & seen[x]) != 0 ? brightness[beside] - value : 0;
      const std::int32_t down = (seen_below[x] & seen[x]) != 0 ? below[x] - value : 0;
      step_sum_[x] += sign * ((right * right + down * down) / 4);
      sum_[x] += sign * value;
      square_sum_[x] += sign * value * value;
      count_[x] += sign * (seen[x] & 1);
    }
  };
  for (int y = 0; y < kRadius; ++y) add_row(y, 1);
  for (int y = 0; y < height; ++y) {
    add_row(y + kRadius, 1);
    add_row(y - kRadius - 1, -1);
    const std::size_t at = static_cast<std::size_t>(y) * columns;
    std::int64_t sum = 0, square_sum = 0, count = 0, step_sum = 0;
    const auto add_column = [&](int x, int sign) {
      if (x < 0 || x >= width) return;
      const auto i = static_cast<std::size_t>(x);
      sum += sign * sum_[i];
      square_sum += sign * square_sum_[i];
      count += sign * count_[i];
      step_sum += sign * step_sum_[i];
    };
    for (int x = 0; x < kRadius; ++x) add_column(x, 1);
    for (int x = 0; x < width; ++x) {
      add_column(x + kRadius, 1);
      add_column(x - kRadius - 1, -1);
      const std::size_t i = at + static_cast<std::size_t>(x);
      if (plane.seen[i] == 0) {
        plane.level[i] = ContrastPlane::kMiddle;
        continue;
      }
      const float n = static_cast<float>(count);
      const float mean = static_cast<float>(sum) / n;
      const float variance = std::max(0.0F, static_cast<float>(square_sum) / n - mean * mean);
      const float noise = static_cast<float>(step_sum) / n;
      const bool noise_only =
          variance < kNoiseRatio * noise + 1.0F && variance < kNeverPlain * kNeverPlain;
      plane.plain[i] = noise_only ? 1 : 0;
      const float deviation =
          (static_cast<float>(brightness_[i]) - mean) / std::sqrt(variance + kPlain * kPlain);
      plane.level[i] =
          static_cast<std::uint8_t>(std::clamp(128.5F + kGain * deviation, 0.0F, 255.0F));
    }
  }
}

}  // namespace kawara::vision
