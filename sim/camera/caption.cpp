#include "sim/camera/caption.hpp"

#include <array>
#include <cstdio>
#include <opencv2/imgproc.hpp>

namespace kawara::sim {
namespace {

constexpr int kCells = 80;
constexpr int kCellPx = 16;
constexpr int kWidthPx = kCells * kCellPx;
constexpr int kHeightPx =
    kWidthPx * static_cast<int>(kCaptionHeight_deg) / static_cast<int>(kCaptionWidth_deg);
constexpr int kStripTopPx = kHeightPx * 2 / 3;

std::uint16_t Crc16(std::uint64_t bits) {
  std::uint16_t crc = 0xFFFF;
  for (int shift = 63; shift >= 0; --shift) {
    const bool bit = ((bits >> shift) & 1U) != 0;
    const bool top = (crc & 0x8000U) != 0;
    crc = static_cast<std::uint16_t>(unsigned{crc} << 1);
    if (bit != top) crc ^= 0x1021U;
  }
  return crc;
}

}  // namespace

std::uint32_t Caption::exposure_ms_of_week() const {
  return static_cast<std::uint32_t>(core::ToWeek(exposure).time_of_week.count() / 1'000'000);
}

cv::Mat DrawCaption(const Caption& caption) {
  cv::Mat picture(kHeightPx, kWidthPx, CV_8UC1, cv::Scalar(0));
  const std::uint32_t ms = caption.exposure_ms_of_week();
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "# %06u  %06u.%03u s", caption.trigger_sequence,
                ms / 1000, ms % 1000);
  constexpr int kThickness = 7;
  double scale = 3.0;
  int baseline = 0;
  const cv::Size size =
      cv::getTextSize(text.data(), cv::FONT_HERSHEY_SIMPLEX, scale, kThickness, &baseline);
  scale *= 0.96 * kWidthPx / size.width;
  cv::putText(picture, text.data(), {kWidthPx / 50, kStripTopPx - kHeightPx / 8},
              cv::FONT_HERSHEY_SIMPLEX, scale, cv::Scalar(255), kThickness, cv::LINE_AA);

  const std::uint64_t data = (std::uint64_t{caption.trigger_sequence} << 32) | ms;
  const std::uint16_t crc = Crc16(data);
  for (int cell = 0; cell < kCells; ++cell) {
    const bool one =
        cell < 64 ? ((data >> (63 - cell)) & 1U) != 0 : ((crc >> (kCells - 1 - cell)) & 1U) != 0;
    cv::rectangle(picture, cv::Rect(cell * kCellPx, kStripTopPx, kCellPx, kHeightPx - kStripTopPx),
                  cv::Scalar(one ? 255 : 0), cv::FILLED);
  }
  return picture;
}

std::optional<CaptionReading> ReadCaption(const cv::Mat& picture) {
  if (picture.cols < 2 * kCells || picture.rows < 24) return std::nullopt;
  cv::Mat grey = picture;
  if (picture.channels() == 3) cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  std::uint64_t data = 0;
  std::uint16_t crc = 0;
  const int row = picture.rows * 5 / 6;  // middle of the strip
  const double pitch = static_cast<double>(picture.cols) / kCells;
  for (int cell = 0; cell < kCells; ++cell) {
    const int from = static_cast<int>((cell + 0.3) * pitch);
    const int to = std::max(from + 1, static_cast<int>((cell + 0.7) * pitch));
    const cv::Mat middle =
        grey(cv::Rect(from, row - picture.rows / 24, to - from, std::max(picture.rows / 12, 1)));
    const unsigned bit = cv::mean(middle)[0] > 127.5 ? 1U : 0U;
    if (cell < 64) {
      data = (data << 1) | bit;
    } else {
      crc = static_cast<std::uint16_t>((unsigned{crc} << 1) | bit);
    }
  }
  if (crc != Crc16(data)) return std::nullopt;
  return CaptionReading{static_cast<std::uint32_t>(data >> 32),
                        static_cast<std::uint32_t>(data & 0xFFFFFFFFU)};
}

}  // namespace kawara::sim
