#pragma once
#include <cstdint>
#include <vector>

#include "vision/stereo/epipolar_grid.hpp"

namespace kawara::vision {

/// A picture on an epipolar grid. A pixel is red, green, blue and 255 in the four bytes of a word,
/// lowest first; 0 where the camera sees nothing. Rows without padding; the words before the first
/// and behind the last pixel are there for kernels that look at neighbours.
class RectifiedPicture {
 public:
  EpipolarGrid grid;

  /// All 0 if it was smaller before; else whatever it was.
  void Resize(const EpipolarGrid& new_grid) {
    grid = new_grid;
    words_.resize(grid.pixels() + 2 * kMargin);
  }
  const std::uint32_t* row(int y) const { return words_.data() + Offset(y); }
  std::uint32_t* row(int y) { return words_.data() + Offset(y); }

 private:
  static constexpr std::size_t kMargin = 16;
  std::size_t Offset(int y) const {
    return kMargin + static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.width_px);
  }
  std::vector<std::uint32_t> words_;
};

/// Each pixel the mean of four of `picture`'s; seen where all four are.
void Halve(const RectifiedPicture& picture, RectifiedPicture& half);

inline bool Seen(std::uint32_t rgbx) { return rgbx >= 0xFF000000U; }

}  // namespace kawara::vision
