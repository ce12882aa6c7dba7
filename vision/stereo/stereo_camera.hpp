#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "vision/camera/camera_model.hpp"
#include "vision/camera/radial_projection.hpp"
#include "vision/stereo/masked_rays.hpp"

namespace kawara::vision {

/// Everything about a camera that stereo computes once for all its pictures. Immutable after
/// construction; any thread.
class StereoCamera {
 public:
  /// `mask`: see MaskedRays.
  explicit StereoCamera(std::shared_ptr<const CameraModel> model,
                        const std::vector<std::uint8_t>& mask = {})
      : model_(std::move(model)),
        rays_(*model_, mask),
        projection_(RadialProjection::Create(*model_)),
        mean_px_per_rad_(MeanResolution(rays_)) {}

  const CameraModel& model() const { return *model_; }
  const MaskedRays& rays() const { return rays_; }
  /// Empty: not symmetric; rays are projected one by one, which is slower.
  const std::optional<RadialProjection>& projection() const { return projection_; }
  double mean_px_per_rad() const { return mean_px_per_rad_; }

 private:
  std::shared_ptr<const CameraModel> model_;
  MaskedRays rays_;
  std::optional<RadialProjection> projection_;
  double mean_px_per_rad_;
};

}  // namespace kawara::vision
