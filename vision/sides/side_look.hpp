#pragma once
#include <Eigen/Core>
#include <vector>

#include "vision/sides/side_grid.hpp"
#include "vision/sides/side_texture.hpp"

namespace kawara::vision {

/// What one picture is good for at each node of a side.
struct SideLook {
  std::vector<Eigen::Vector2f> pixel;  ///< where the node is in the picture; NaN: not in it
  /// Pixels a texel where they are fewest, at most 1, times the cosine of incidence; less beside
  /// what hides something, and where no range tells. 0: not to be used. A node that is used, and
  /// all eight around it, are in the picture and not masked.
  std::vector<float> quality;
  double total = 0.0;  ///< sum of quality
};

struct LookRules {
  double min_incidence_cos = 0.1;
  /// Nearer by this (along the normal) and three deviations of the range hides a node.
  double depth_margin_m = 0.15;
};

SideLook LookAtSide(const SideGrid& grid, const SideView& view, const LookRules& rules);

}  // namespace kawara::vision
