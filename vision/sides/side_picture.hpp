#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "vision/sides/side_grid.hpp"
#include "vision/sides/side_look.hpp"
#include "vision/sides/side_texture.hpp"

namespace kawara::vision {

/// A side painted from the views that show it best.
struct SidePicture {
  std::vector<std::uint8_t> rgb;  ///< [height_px][width_px] of the grid
  double seen_share = 0.0;
  std::size_t main_view = 0;  ///< shows most of it; of nothing seen: 0
};

/// Nothing seen: no pixels.
SidePicture PaintSide(const SideGrid& grid, std::span<const SideView> views,
                      const LookRules& rules);

}  // namespace kawara::vision
