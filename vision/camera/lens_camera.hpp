#pragma once
#include <memory>

#include "core/expected.hpp"
#include "vision/camera/camera_model.hpp"
#include "vision/camera/lens_law.hpp"
#include "vision/camera/optical_axis.hpp"

namespace kawara::vision {

/// A picture behind a lens law: its size, and how the law's plane lies in it.
struct LensPicture {
  int width_px = 0;
  int height_px = 0;
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();  ///< where the optical axis pierces it
  /// Takes points of the plane (x right, y down) to pixels from the centre: focal lengths on the
  /// diagonal (of OcamLaw: about one), skew beside.
  Eigen::Matrix2d affine = Eigen::Matrix2d::Identity();
  bool mirrored = false;  ///< see optical_axis.hpp
  OpticalAxis axis = OpticalAxis::kForward;
};

/// Lens or central mirror with any LensLaw: camera frame -> optical frame -> plane -> pixel.
class LensCamera final : public CameraModel {
 public:
  /// kInvalidArgument: sizes, an affine that cannot be inverted, a law that sees nothing.
  static core::Expected<LensCamera> Create(std::shared_ptr<const LensLaw> law,
                                           const LensPicture& picture);

  const LensLaw& law() const { return *law_; }
  int width_px() const override { return picture_.width_px; }
  int height_px() const override { return picture_.height_px; }
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& ray_camera) const override;
  std::optional<Eigen::Vector3d> Unproject(const Eigen::Vector2d& pixel_px) const override;
  ElevationRange Elevations() const override { return elevations_; }
  std::optional<RadialSymmetry> Symmetry() const override;

 private:
  LensCamera(std::shared_ptr<const LensLaw> law, const LensPicture& picture);
  ElevationRange FindElevations() const;

  std::shared_ptr<const LensLaw> law_;
  LensPicture picture_;
  Eigen::Matrix3d R_optical_camera_;
  Eigen::Matrix2d affine_;  ///< with the mirror in it
  Eigen::Matrix2d inverse_affine_;
  ElevationRange elevations_;  ///< of the picture's pixels, to a few pixels
};

}  // namespace kawara::vision
