#pragma once
#include <Eigen/Core>
#include <span>

#include "vision/stereo/range_image.hpp"

namespace kawara::vision {

/// A distance image of a view, and where from there the picture that it was made with was taken.
struct RangeEstimate {
  const RangeImage* ranges = nullptr;
  Eigen::Vector3d baseline_m = Eigen::Vector3d::Zero();  ///< any frame that all estimates share
};

struct RangeFusionOptions {
  /// Two estimates agree when they differ by this many deviations of their difference, or less.
  double agreement_sd = 3.0;
  /// Parts of an estimate's variance that it has in common with the others. The noise of the view's
  /// own picture and pose moves estimates from opposite sides in opposite directions; what the
  /// matcher makes of the picture's edges moves all of them alike. Measured on rendered streets:
  /// correlations of +0.37 on the same side and -0.17 on opposite ones.
  double shared_directed = 0.27;
  double shared_alike = 0.10;
  /// Where several looked and one alone found something, its deviation is this many times as large:
  /// it is the edge of what can be seen.
  double alone_factor = 2.0;
  double largest_relative_sd = 0.06;  ///< of a range that is kept
};

constexpr std::size_t kMostRangeEstimates = 16;

/// Several distance images of one view become one. In every pixel the group of estimates that agree
/// with one of them (in inverse range, whose errors are nearly Gaussian) and have the largest sum
/// of inverse variances, in a tie that about the shortest baseline's, gives the weighted mean.
/// Unknown where the group is not the majority of the estimates: a lone one must be contradicted by
/// none.
///
/// The deviation is that of a weighted mean of correlated estimates; more than it when they scatter
/// by more than they claim (the ratio of Birge, "The calculation of errors by the method of least
/// squares", Phys. Rev. 40, 1932). One estimate alone in the list comes out as it is.
///
/// All images have one size, and there are 1 to kMostRangeEstimates of them (CORE_CHECK); ranges
/// are positive or NaN. The order of the list does not matter, except for equal baselines in a tie.
/// Any thread; `fused` is none of the estimates.
void FuseRanges(std::span<const RangeEstimate> estimates, const RangeFusionOptions& options,
                RangeImage& fused);

}  // namespace kawara::vision
