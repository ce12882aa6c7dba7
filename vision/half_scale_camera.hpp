#pragma once
#include <algorithm>

#include "vision/camera_model.hpp"

namespace kawara::vision {

/// The same camera with pixels twice as wide and high, corner on corner: the camera of the chroma
/// planes of its 4:2:0 pictures (yuv420.hpp). Of an odd size the last pixels stick out by half; the
/// part that sticks out looks where the picture ends. Refers to `full`, which must outlive it.
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
    const Eigen::Array2d corner_px = 2.0 * (pixel_px.array() + 0.5);  // from the picture's corner
    const Eigen::Array2d size_px(full_.width_px(), full_.height_px());
    return full_.Unproject((corner_px.min(size_px) - 0.5).matrix());
  }

  ElevationRange Elevations() const override { return full_.Elevations(); }

 private:
  const CameraModel& full_;
};

}  // namespace kawara::vision
