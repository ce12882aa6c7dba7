#pragma once
#include "vision/camera/radial_laws.hpp"

namespace kawara::vision {

/// UnifiedLaw with the tangential terms of a lens that is not centred, as OpenCV's cv::omnidir (and
/// with xi = 0 its pinhole) and Kalibr's "omni radtan" write them: with (x, y) undistorted and
/// s = x^2 + y^2
///   x' = x (1 + k1 s + k2 s^2 + k3 s^3) + 2 p1 x y + p2 (s + 2 x^2),
///   y' = y (...) + p1 (s + 2 y^2) + 2 p2 x y.
/// Domain: UnifiedLaw's, as far as the formula does not fold (Jacobian of positive determinant).
class TangentialLaw final : public LensLaw {
 public:
  TangentialLaw(const UnifiedLaw& radial, double p1, double p2)
      : radial_(radial), p1_(p1), p2_(p2) {}
  std::optional<Eigen::Vector2d> ToPlane(const Eigen::Vector3d& ray_optical) const override;
  std::optional<Eigen::Vector3d> ToRay(const Eigen::Vector2d& plane) const override;
  bool IsSymmetric() const override { return false; }
  double max_angle_rad() const override { return radial_.max_angle_rad(); }

 private:
  Eigen::Vector2d Distorted(const Eigen::Vector2d& m) const;
  Eigen::Matrix2d Jacobian(const Eigen::Vector2d& m) const;
  UnifiedLaw radial_;
  double p1_, p2_;
};

}  // namespace kawara::vision
