#pragma once
#include <Eigen/Geometry>
#include <vector>

#include "core/expected.hpp"
#include "vision/image.hpp"
#include "vision/stereo/coarse_matcher.hpp"
#include "vision/stereo/disparity_refiner.hpp"
#include "vision/stereo/epipolar_pair.hpp"
#include "vision/stereo/range_image.hpp"
#include "vision/stereo/rectifier.hpp"

namespace kawara::vision {

/// What the fast method searches, and what it keeps.
struct PairMatcherOptions {
  double px_per_rad = 0.0;  ///< of the epipolar grid; 0: the camera's own, MeanResolution()
  double nearest_m = 1.5;   ///< nothing nearer is looked for
  double pole_cap_rad = 10.0 * core::kRadFromDeg;
  double largest_relative_sd = 0.06;  ///< of a range that is kept
};

/// One view of a pair.
struct StereoView {
  const StereoCamera* camera = nullptr;
  ConstImageView picture;
  Eigen::Isometry3d map_from_camera = Eigen::Isometry3d::Identity();
};

/// Two pictures and their poses to the distance image of the first, the fast way: epipolar
/// rectification, semi-global search at half size, sub-pixel refinement at full size. Any two
/// camera models, any motion. Memory is kept from pair to pair; one thread at a time.
class PairMatcher {
 public:
  explicit PairMatcher(const PairMatcherOptions& options) : options_(options) {}

  /// kInvalidArgument: no baseline.
  core::Expected<void> Match(const StereoView& a, const StereoView& b, RangeImage& ranges);

  /// Of the last Match, for who wants to look at it.
  const EpipolarGrid& grid() const { return rectified_a_.grid; }
  const DisparityField& field() const { return field_; }
  const RectifiedPicture& rectified_a() const { return rectified_a_; }
  const RectifiedPicture& rectified_b() const { return rectified_b_; }

 private:
  void SearchCoarsely(const RectifiedPicture& a, const RectifiedPicture& b, double baseline_m);
  void ToRanges(const StereoCamera& camera, const EpipolarPair& pair, RangeImage& ranges) const;

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

/// Pixels per radian of a camera, as the square root of its pixels per steradian.
double MeanResolution(const MaskedRays& rays);

}  // namespace kawara::vision
