#pragma once
#include <cstdint>
#include <vector>

#include "vision/stereo/rectified_picture.hpp"

namespace kawara::vision {

/// What the coarse search compares: brightness at half the picture's size, less its mean over the
/// neighbourhood and divided by its contrast there. Exposure, shading and shadow drop out; where
/// there is nothing but noise it stays near kMiddle.
struct ContrastPlane {
  static constexpr std::uint8_t kMiddle = 128;

  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> level;
  std::vector<std::uint8_t> seen;  ///< 255 where the camera sees, else 0
  /// 1 where the neighbourhood holds nothing but noise: a disparity there would be its
  /// neighbours'.
  std::vector<std::uint8_t> plain;
};

/// Makes such planes; keeps its memory. One thread at a time.
class ContrastMaker {
 public:
  void Make(const RectifiedPicture& picture, ContrastPlane& plane);

 private:
  void HalveBrightness(const RectifiedPicture& picture, ContrastPlane& plane);

  std::vector<std::uint16_t> brightness_;  ///< sum of twelve bytes
  /// Of columns, over the rows of the window; steps: squared differences to the right and below.
  std::vector<std::int32_t> sum_, square_sum_, count_, step_sum_;
};

}  // namespace kawara::vision
