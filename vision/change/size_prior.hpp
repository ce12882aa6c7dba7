#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/changed_object.hpp"

namespace kawara::vision {

/// What was seen of one of a box's dimensions.
struct SeenExtent {
  double extent_m = 0.0;  ///< between what was seen
  double sd_m = 0.1;
  /// Both of its ends were seen; otherwise the thing is at least so long.
  bool both_ends = false;
};

/// What such things measure: length, width, height with deviations, as a weight on what was seen
/// and never as a rule. `kUnknown` has no size of its own: any is as good as another.
struct SizeGuess {
  core::SizeClass cls = core::SizeClass::kUnknown;
  double probability = 0.0;                          ///< of the class
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  ///< of the whole, hidden parts included
  Eigen::Vector3d sd_m = Eigen::Vector3d::Zero();
  double log_evidence = 0.0;  ///< of these extents under all classes: higher fits better
};

/// Class and whole size from the extents of length, width and height. `regular`: its sides are
/// plane and upright, as a vehicle's; heaps are not (0..1). Sources of the sizes: Japan's Road
/// Transport Vehicle Act, article 2 of the safety standards (12 x 2.5 x 3.8 m at most; light motor
/// vehicles 3.4 x 1.48 x 2.0 m, small ones 4.7 x 1.7 x 2.0 m).
SizeGuess GuessSize(const std::array<SeenExtent, 3>& seen, double regular);

}  // namespace kawara::vision
