#pragma once
#include <cstddef>
#include <limits>
#include <vector>

namespace kawara::vision {

/// How far away what each pixel of a camera's picture shows is: the paper's distance image
/// (section 4C), with an honest deviation for every pixel. Rows from the top, the camera's own
/// pixels.
struct RangeImage {
  static constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

  int width_px = 0;
  int height_px = 0;
  std::vector<float> range_m;  ///< along the pixel's ray from the viewpoint; NaN: not known
  std::vector<float> sd_m;     ///< one standard deviation of it; NaN where range_m is

  void Reset(int width, int height) {
    width_px = width;
    height_px = height;
    const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    range_m.assign(pixels, kUnknown);
    sd_m.assign(pixels, kUnknown);
  }
  std::size_t index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_px) +
           static_cast<std::size_t>(u);
  }
};

}  // namespace kawara::vision
