#pragma once
#include <cstdint>
#include <vector>

#include "vision/camera/camera_model.hpp"
#include "vision/image.hpp"

namespace kawara::vision {

/// A camera's unit rays, computed once: [height][width] of each component in the camera frame, NaN
/// where a pixel sees nothing valid or is masked. Immutable after construction; any thread.
class MaskedRays {
 public:
  /// `mask`, if not empty, [height][width]: 0 hides a pixel (the robot's own body).
  explicit MaskedRays(const CameraModel& camera, const std::vector<std::uint8_t>& mask = {});

  int width_px() const { return width_px_; }
  int height_px() const { return height_px_; }
  const float* x() const { return x_.data(); }
  const float* y() const { return y_.data(); }
  const float* z() const { return z_.data(); }
  bool seen(std::size_t pixel) const { return seen_[pixel] != 0; }

  /// The picture with red, green, blue in the low bytes of a word and 255 in the fourth where
  /// the camera sees, all 0 where not. The picture is of this camera's size (CORE_CHECK).
  void Pack(const ConstImageView& picture, std::vector<std::uint32_t>& rgbx) const;

 private:
  int width_px_, height_px_;
  std::vector<float> x_, y_, z_;
  std::vector<std::uint8_t> seen_;
};

/// Pixels per radian of a camera, as the square root of its pixels per steradian.
double MeanResolution(const MaskedRays& rays);

}  // namespace kawara::vision
