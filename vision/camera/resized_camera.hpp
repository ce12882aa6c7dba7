#pragma once
#include <memory>
#include <utility>

#include "vision/camera/camera_model.hpp"

namespace kawara::vision {

/// The same camera in a picture of another size, corner on corner: a calibration of full size for
/// pictures that were reduced. Immutable; any thread.
class ResizedCamera final : public CameraModel {
 public:
  ResizedCamera(std::shared_ptr<const CameraModel> original, int width_px, int height_px)
      : original_(std::move(original)),
        width_px_(width_px),
        height_px_(height_px),
        scale_(static_cast<double>(width_px) / original_->width_px(),
               static_cast<double>(height_px) / original_->height_px()) {}

  int width_px() const override { return width_px_; }
  int height_px() const override { return height_px_; }

  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& ray_camera) const override {
    auto pixel = original_->Project(ray_camera);
    if (pixel) *pixel = Resized(*pixel);
    return pixel;
  }

  std::optional<Eigen::Vector3d> Unproject(const Eigen::Vector2d& pixel_px) const override {
    return original_->Unproject((pixel_px.array() + 0.5) / scale_.array() - 0.5);
  }

  ElevationRange Elevations() const override { return original_->Elevations(); }

  std::optional<RadialSymmetry> Symmetry() const override {
    auto symmetry = original_->Symmetry();
    if (symmetry) {
      symmetry->center_px = Resized(symmetry->center_px);
      symmetry->affine = (scale_.asDiagonal() * symmetry->affine).eval();
    }
    return symmetry;
  }

 private:
  Eigen::Vector2d Resized(const Eigen::Vector2d& pixel_px) const {
    return (pixel_px.array() + 0.5) * scale_.array() - 0.5;
  }

  std::shared_ptr<const CameraModel> original_;
  int width_px_, height_px_;
  Eigen::Vector2d scale_;
};

}  // namespace kawara::vision
