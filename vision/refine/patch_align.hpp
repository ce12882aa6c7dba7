#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <optional>

namespace kawara::vision {

/// A picture of grey levels, row by row. Does not own it.
struct LevelsView {
  const float* data = nullptr;
  int width_px = 0, height_px = 0;
  std::ptrdiff_t stride = 0;  ///< of rows [floats]

  const float* row(int y) const { return data + y * stride; }
};

struct PatchAlignOptions {
  int half_px = 9;           ///< of the patch, which is square
  int most_steps = 12;       ///< of Gauss and Newton
  float still_px = 0.005F;   ///< a step smaller than this ends them
  float farthest_px = 2.5F;  ///< from where it began; then it is lost
};

/// Where the patch of `a` about `at_a` lies in `b`, to hundredths of a pixel, begun at `guess`.
/// Both pictures have their rows along epipolar curves: what a plane in the world does to
/// a patch between them is to stretch it and to shear it along the rows, and both are estimated
/// with the place, as are gain and offset of the brightness. A patch that may only be shifted is
/// drawn to its nearer part instead, always to the same side of it. Reentrant; nothing: it left the
/// picture, or did not settle.
std::optional<Eigen::Vector2f> AlignPatch(const LevelsView& a, const LevelsView& b,
                                          const Eigen::Vector2f& at_a, const Eigen::Vector2f& guess,
                                          const PatchAlignOptions& options = {});

}  // namespace kawara::vision
