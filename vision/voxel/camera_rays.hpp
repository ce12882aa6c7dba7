#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "vision/camera/camera_model.hpp"

namespace kawara::vision {

/// Unit rays of a camera's pixels in its frame, component by component, rows from the top; NaN:
/// sees nothing. Owns nothing.
struct RayTables {
  const float *x = nullptr, *y = nullptr, *z = nullptr;
};

/// A camera as two tables, for loops over every pixel: the unit ray of each pixel, and the pixel
/// nearest to each direction (six faces of a cube). One object a camera; immutable after
/// construction; any thread.
class CameraRays {
 public:
  static constexpr std::int32_t kNoPixel = -1;

  explicit CameraRays(const CameraModel& camera);
  /// With somebody else's rays of this camera, which must outlive this.
  CameraRays(const CameraModel& camera, const RayTables& rays);
  CameraRays(CameraRays&&) = default;
  CameraRays& operator=(CameraRays&&) = default;

  int width_px() const { return width_px_; }
  int height_px() const { return height_px_; }
  std::size_t pixels() const {
    return static_cast<std::size_t>(width_px_) * static_cast<std::size_t>(height_px_);
  }

  const float* x() const { return rays_.x; }
  const float* y() const { return rays_.y; }
  const float* z() const { return rays_.z; }
  Eigen::Vector3f ray(std::size_t pixel) const {
    return {rays_.x[pixel], rays_.y[pixel], rays_.z[pixel]};
  }

  /// Pixel (row * width + column) that looks along `direction_camera` (any length but zero), within
  /// about a pixel; kNoPixel outside the picture or the field of view.
  std::int32_t PixelOf(const Eigen::Vector3f& direction_camera) const {
    return PixelAt(TexelOf(direction_camera));
  }
  /// PixelOf in steps, for who has many directions to ask for: the table is larger than a
  /// processor's caches, and what is prefetched early costs no waiting.
  std::size_t TexelOf(const Eigen::Vector3f& direction_camera) const {
    int axis = 0;
    direction_camera.cwiseAbs().maxCoeff(&axis);
    const float major = direction_camera[axis];
    const auto [u, v] = kOtherAxes[static_cast<std::size_t>(axis)];
    const float scale = half_face_ / std::abs(major);
    const std::size_t column = Texel(direction_camera[u] * scale);
    const std::size_t row = Texel(direction_camera[v] * scale);
    const std::size_t face = 2 * static_cast<std::size_t>(axis) + (major < 0.0F ? 1U : 0U);
    return (face * face_px_ + row) * face_px_ + column;
  }
  void Prefetch(std::size_t texel) const { __builtin_prefetch(nearest_.data() + texel); }
  std::int32_t PixelAt(std::size_t texel) const { return nearest_[texel]; }
  /// How many pixels look into a steradian around this one: 1 / its solid angle.
  float PixelsPerSteradian(std::int32_t pixel) const;

  std::size_t memory_bytes() const {
    return 3 * own_x_.size() * sizeof(float) + nearest_.size() * sizeof(std::int32_t);
  }

 private:
  static constexpr std::array<std::array<int, 2>, 3> kOtherAxes{{{1, 2}, {2, 0}, {0, 1}}};

  std::size_t Texel(float offset) const {
    const auto texel = static_cast<std::size_t>(std::max(offset + half_face_, 0.0F));
    return texel < face_px_ ? texel : face_px_ - 1;
  }
  void MakeRays(const CameraModel& camera);
  std::size_t ChooseFace() const;
  void FillFaces(const CameraModel& camera);

  int width_px_ = 0, height_px_ = 0;
  std::vector<float> own_x_, own_y_, own_z_;  ///< empty if the rays are somebody else's
  RayTables rays_;
  std::size_t face_px_ = 0;
  float half_face_ = 0.0F;
  std::vector<std::int32_t> nearest_;
};

}  // namespace kawara::vision
