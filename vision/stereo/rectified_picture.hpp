#pragma once
#include <cstdint>
#include <vector>

#include "vision/stereo/epipolar_grid.hpp"

namespace kawara::vision {

/// A picture on an epipolar grid. A pixel is red, green, blue and 255 in the four bytes of a word,
/// lowest first; 0 where the camera sees nothing. Rows without padding.
struct RectifiedPicture {
  EpipolarGrid grid;
  std::vector<std::uint32_t> rgbx;

  void Reset(const EpipolarGrid& new_grid) {
    grid = new_grid;
    rgbx.assign(grid.pixels(), 0);
  }
  const std::uint32_t* row(int y) const {
    return rgbx.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.width_px);
  }
};

/// Each pixel the mean of four of `picture`'s; seen where all four are.
void Halve(const RectifiedPicture& picture, RectifiedPicture& half);

inline bool Seen(std::uint32_t rgbx) { return rgbx >= 0xFF000000U; }

}  // namespace kawara::vision
