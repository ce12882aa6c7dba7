#pragma once
#include "vision/camera/camera_model.hpp"

namespace kawara::vision {

/// The same camera with pixels twice as wide and high, corner on corner: the camera of the chroma
/// planes of its 4:2:0 pictures (yuv420.hpp). Of an odd size the last pixels stand for one pixel of
/// `full` instead of two (what JPEG encoders do, repeating it). Refers to `full`, which must
/// outlive it. Symmetry() is not told: nobody matches chroma.
class HalfScaleCamera final : public CameraModel {
 public:
  explicit HalfScaleCamera(const CameraModel& full) : full_(full) {}

  int width_px() const override { return (full_.width_px() + 1) / 2; }
  int height_px() const override { return (full_.height_px() + 1) / 2; }

  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& ray_camera) const override {
    auto pixel = full_.Project(ray_camera);
    if (pixel) *pixel = (pixel->array() + 0.5) / 2.0 - 0.5;
    return pixel;
  }

  std::optional<Eigen::Vector3d> Unproject(const Eigen::Vector2d& pixel_px) const override {
    return full_.Unproject(
        {FullPixel(pixel_px.x(), full_.width_px()), FullPixel(pixel_px.y(), full_.height_px())});
  }

  ElevationRange Elevations() const override { return full_.Elevations(); }

 private:
  static double FullPixel(double half_px, int full_size_px) {
    const double from_corner_px = 2.0 * (half_px + 0.5);
    const int last_px = full_size_px - 1;
    const bool half_is_beyond = full_size_px % 2 == 1 && from_corner_px > last_px;
    return (half_is_beyond ? (from_corner_px + last_px) / 2.0 : from_corner_px) - 0.5;
  }

  const CameraModel& full_;
};

}  // namespace kawara::vision
