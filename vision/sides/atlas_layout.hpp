#pragma once
#include <array>
#include <optional>
#include <span>
#include <vector>

namespace kawara::vision {

/// Where pictures of given sizes go in one, on shelves, the highest first; a margin around each.
struct AtlasLayout {
  static constexpr int kMarginPx = 2;  ///< a picture's edge goes on in it

  int width_px = 0, height_px = 0;        ///< whole blocks of a JPEG
  std::vector<std::array<int, 2>> place;  ///< of each picture's upper left pixel: column, row
};

/// Empty: they do not fit a square of `max_px`. `sizes`: width and height [px].
std::optional<AtlasLayout> LayOut(std::span<const std::array<int, 2>> sizes, int max_px);

}  // namespace kawara::vision
