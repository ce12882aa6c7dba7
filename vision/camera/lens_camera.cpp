#include "vision/camera/lens_camera.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace kawara::vision {

core::Expected<LensCamera> LensCamera::Create(std::shared_ptr<const LensLaw> law,
                                              const LensPicture& picture) {
  const auto refuse = [](const std::string& what) {
    return core::Fail(core::ErrorCode::kInvalidArgument, "lens camera: " + what);
  };
  if (picture.width_px < 2 || picture.height_px < 2) {
    return refuse("picture of " + std::to_string(picture.width_px) + " x " +
                  std::to_string(picture.height_px) + " px: expected at least 2 x 2");
  }
  if (!picture.center_px.allFinite() || !picture.affine.allFinite() ||
      !(std::abs(picture.affine.determinant()) > 1e-9)) {
    return refuse("focal lengths, skew and centre: expected finite numbers, focal lengths not 0");
  }
  if (!(law->max_angle_rad() > 1e-3)) {
    return refuse("these coefficients do not map even the surroundings of the optical axis");
  }
  return LensCamera(std::move(law), picture);
}

LensCamera::LensCamera(std::shared_ptr<const LensLaw> law, const LensPicture& picture)
    : law_(std::move(law)),
      picture_(picture),
      R_optical_camera_(CameraFromOptical(picture.axis).transpose()),
      affine_(picture.affine) {
  if (picture.mirrored) affine_.col(0) *= -1.0;
  inverse_affine_ = affine_.inverse();
  elevations_ = FindElevations();
}

std::optional<Eigen::Vector2d> LensCamera::Project(const Eigen::Vector3d& ray_camera) const {
  const double length = ray_camera.norm();
  if (!(length > 0.0)) return {};
  const auto plane = law_->ToPlane(R_optical_camera_ * (ray_camera / length));
  if (!plane) return {};
  return picture_.center_px + affine_ * *plane;
}

std::optional<Eigen::Vector3d> LensCamera::Unproject(const Eigen::Vector2d& pixel_px) const {
  const auto ray = law_->ToRay(inverse_affine_ * (pixel_px - picture_.center_px));
  if (!ray) return {};
  return R_optical_camera_.transpose() * *ray;
}

std::optional<RadialSymmetry> LensCamera::Symmetry() const {
  if (!law_->IsSymmetric()) return {};
  RadialSymmetry symmetry;
  symmetry.R_optical_camera = R_optical_camera_;
  symmetry.center_px = picture_.center_px;
  symmetry.affine = affine_;
  symmetry.z_min = std::cos(law_->max_angle_rad());
  return symmetry;
}

// Over a grid with the picture's edges in it; straight up and down lie between its points.
ElevationRange LensCamera::FindElevations() const {
  constexpr int kGrid = 128;
  ElevationRange range{core::kPi / 2, -core::kPi / 2};
  const auto widen = [&](double elevation_rad) {
    range.bottom_rad = std::min(range.bottom_rad, elevation_rad);
    range.top_rad = std::max(range.top_rad, elevation_rad);
  };
  for (int i = 0; i <= kGrid; ++i) {
    for (int k = 0; k <= kGrid; ++k) {
      const auto ray = Unproject({-0.5 + picture_.width_px * i / static_cast<double>(kGrid),
                                  -0.5 + picture_.height_px * k / static_cast<double>(kGrid)});
      if (ray) widen(std::asin(std::clamp(ray->x(), -1.0, 1.0)));
    }
  }
  for (const double up : {-1.0, 1.0}) {
    const auto pixel = Project({up, 0.0, 0.0});
    if (pixel && pixel->x() >= -0.5 && pixel->y() >= -0.5 &&
        pixel->x() <= picture_.width_px - 0.5 && pixel->y() <= picture_.height_px - 0.5) {
      widen(up * core::kPi / 2);
    }
  }
  return range.bottom_rad <= range.top_rad ? range : ElevationRange{0.0, 0.0};
}

}  // namespace kawara::vision
