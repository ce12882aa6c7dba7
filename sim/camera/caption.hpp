#pragma once
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>

#include "sim/camera/picture_source.hpp"

namespace kawara::sim {

/// Where the caption stands in the camera's field of view: centred on the forward axis, at the foot
/// of the picture.
constexpr double kCaptionWidth_deg = 120.0;
constexpr double kCaptionHeight_deg = 15.0;
constexpr double kCaptionMargin_deg =
    3.0;  ///< between its lower edge and the lower end of the field of view

/// The caption as a grey picture, upright: a line of large digits for people ("# 000012 243300.499
/// s") and under it a strip for programs, the lower third: 80 equal cells, white 1, black 0, most
/// significant first: 32 bits trigger sequence, 32 bits exposure in milliseconds of the GPS week,
/// CRC-16/CCITT (0x1021, initial 0xFFFF) of the two.
cv::Mat DrawCaption(const Caption& caption);

/// Reads the strip of a picture that shows exactly the caption (any size above 160 x 24, grey or
/// colour). Empty: CRC wrong. The second member is exposure_ms_of_week.
struct CaptionReading {
  std::uint32_t trigger_sequence = 0;
  std::uint32_t exposure_ms_of_week = 0;
};
std::optional<CaptionReading> ReadCaption(const cv::Mat& picture);

}  // namespace kawara::sim
