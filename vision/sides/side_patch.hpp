#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "vision/image.hpp"
#include "vision/sides/side_look.hpp"

namespace kawara::vision {

/// A side as one picture shows it, rectified: RGB [height_px][width_px] of the grid. Only cells
/// with a node of some quality are drawn; the others stay black.
struct SidePatch {
  std::vector<std::uint8_t> rgb;
  std::vector<std::uint8_t> whole;  ///< of each cell: 1 if all its nodes are to be used
  /// Of each whole cell: the sum of the squared steps from texel to texel of the logarithm of its
  /// brightness, which neither exposure nor light change.
  std::vector<float> detail;
};

/// A texel is the mean of the picture over the area it covers there, up to 4 x 4 pixels.
SidePatch RectifySide(const SideGrid& grid, const SideLook& look, const ConstImageView& picture);

/// Mean colour of a cell of a patch.
std::array<float, 3> MeanOfCell(const SideGrid& grid, const SidePatch& patch, int i, int j);

}  // namespace kawara::vision
