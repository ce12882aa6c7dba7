#pragma once
#include <vector>

#include "core/expected.hpp"
#include "vision/stereo/coarse_matcher.hpp"
#include "vision/stereo/disparity_refiner.hpp"
#include "vision/stereo/epipolar_pair.hpp"
#include "vision/stereo/range_image.hpp"
#include "vision/stereo/rectifier.hpp"
#include "vision/stereo/stereo_view.hpp"

namespace kawara::vision {

/// What the fast method searches, and what it keeps.
struct PairMatcherOptions {
  double px_per_rad = 0.0;  ///< of the epipolar grid; 0: nine tenths of the camera's own
  double nearest_m = 1.5;   ///< nothing nearer is looked for
  double pole_cap_rad = 10.0 * core::kRadFromDeg;
  double largest_relative_sd = 0.06;  ///< of a range that is kept
};

/// Two pictures and their poses to the distance image of the first, the fast way: epipolar
/// rectification, semi-global search at half size, sub-pixel refinement at full size. Any two
/// camera models, any motion. Memory is kept from pair to pair; one thread at a time.
class PairMatcher {
 public:
  explicit PairMatcher(const PairMatcherOptions& options) : options_(options) {}

  /// `doubt` is in the deviations of all ranges. kInvalidArgument: no baseline.
  core::Expected<void> Match(const StereoView& a, const StereoView& b, RangeImage& ranges,
                             const StepDoubt& doubt = {});

  /// Of the last Match, for who wants to look at it.
  const EpipolarGrid& grid() const { return rectified_a_.grid; }
  const DisparityField& field() const { return field_; }
  const RectifiedPicture& rectified_a() const { return rectified_a_; }
  const RectifiedPicture& rectified_b() const { return rectified_b_; }

 private:
  void SearchCoarsely(const RectifiedPicture& a, const RectifiedPicture& b, double baseline_m);
  void ToRanges(const StereoCamera& camera, const EpipolarPair& pair, const StepDoubt& doubt,
                RangeImage& ranges) const;

  PairMatcherOptions options_;
  Rectifier rectifier_;
  RectifiedPicture rectified_a_, rectified_b_;
  ContrastMaker contrast_;
  ContrastPlane contrast_a_, contrast_b_;
  CoarseMatcher coarse_;
  SpeckleFilter speckles_;
  std::vector<float> coarse_px_;
  DisparityRefiner refiner_;
  DisparityField field_;
  RectifiedPicture half_a_, half_b_;  ///< of dense cameras
  DisparityField half_field_;
};

}  // namespace kawara::vision
