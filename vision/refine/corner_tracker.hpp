#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/expected.hpp"
#include "vision/stereo/epipolar_pair.hpp"
#include "vision/stereo/stereo_camera.hpp"
#include "vision/stereo/stereo_view.hpp"

namespace kawara::vision {

struct CornerTrackerOptions {
  double px_per_rad = 0.0;      ///< of the sphere tracked on; 0: nine tenths of the camera's own
  int wanted = 400;             ///< corners kept alive, spread over the picture
  double least_contrast = 3.0;  ///< of a corner [8-bit levels of gradient, rms, its weaker way]
};

/// Where a corner is seen from the earlier and the later of two views: unit rays, camera frames.
struct TrackedCorner {
  Eigen::Vector3d ray_a, ray_b;
  std::ptrdiff_t known = -1;  ///< index in `known_rays` of Track; -1: a new corner
};

/// Follows corners from one picture to the next. Both are brought onto the sphere that stereo uses
/// (epipolar_pair.hpp): turns between them vanish, and what is left is a small shift away from the
/// pole, whatever the camera's model. There, pyramidal Lucas and Kanade, then as a slanted patch
/// forth and back (patch_align.hpp).
/// The poses only have to be good to some degrees and a quarter of the step. Keeps its memory; one
/// thread at a time.
class CornerTracker {
 public:
  explicit CornerTracker(const CornerTrackerOptions& options);
  ~CornerTracker();
  CornerTracker(CornerTracker&&) noexcept;
  CornerTracker& operator=(CornerTracker&&) noexcept;

  /// `known_rays`: of corners followed before, as A's camera sees them. Those lost are missing from
  /// the answer; new ones fill up what is free. kInvalidArgument: the views are the same place.
  core::Expected<std::vector<TrackedCorner>> Track(const StereoView& a, const StereoView& b,
                                                   const std::vector<Eigen::Vector3d>& known_rays);

  /// Pixels per radian of the sphere last tracked on.
  double px_per_rad() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace kawara::vision
