#include "vision/camera/lens_law.hpp"

#include <algorithm>
#include <cmath>

#include "core/geodesy.hpp"

namespace kawara::vision {
namespace {

constexpr double kStepRad = core::kPi / 9000.0;
// Where a law is flatter than this it cannot be inverted to 1e-9 rad, and is about to fold.
constexpr double kLeastSlopeShare = 1e-3;
// Rounding may put a ray of the rim this far outside the domain.
constexpr double kRimTolerance = 1e-12;

AxialRay RayAt(double angle_rad) { return {std::sin(angle_rad), std::cos(angle_rad)}; }

}  // namespace

void RadialLaw::FindDomain(double wanted_max_angle_rad) {
  const double end_rad = std::clamp(wanted_max_angle_rad, 0.0, core::kPi);
  max_angle_rad_ = max_radius_ = 0.0;
  double least_growth = 0.0;
  while (max_angle_rad_ < end_rad) {
    const double next_rad = std::min(max_angle_rad_ + kStepRad, end_rad);
    const double radius = Radius(RayAt(next_rad));
    const double growth = (radius - max_radius_) / (next_rad - max_angle_rad_);
    // Written so that a radius that is no number ends it too.
    if (!(std::isfinite(radius) && growth > least_growth)) break;
    if (max_angle_rad_ == 0.0) least_growth = kLeastSlopeShare * growth;
    max_angle_rad_ = next_rad;
    max_radius_ = radius;
  }
}

std::optional<Eigen::Vector2d> RadialLaw::ToPlane(const Eigen::Vector3d& ray_optical) const {
  const double rho = std::hypot(ray_optical.x(), ray_optical.y());
  if (!(std::atan2(rho, ray_optical.z()) <= max_angle_rad_ + kRimTolerance)) return {};
  if (rho == 0.0) {
    if (ray_optical.z() <= 0.0) return {};  // straight back: every direction of the rim at once
    return Eigen::Vector2d(0.0, 0.0);
  }
  const Eigen::Vector2d plane = ray_optical.head<2>() * (Radius({rho, ray_optical.z()}) / rho);
  if (!plane.allFinite()) return {};
  return plane;
}

std::optional<Eigen::Vector3d> RadialLaw::ToRay(const Eigen::Vector2d& plane) const {
  const double radius = plane.norm();
  if (!(radius <= max_radius_ * (1.0 + kRimTolerance))) return {};
  if (radius == 0.0) return Eigen::Vector3d(0.0, 0.0, 1.0);
  const AxialRay ray = Ray(std::min(radius, max_radius_));
  const Eigen::Vector2d across = plane * (ray.rho / radius);
  const Eigen::Vector3d direction(across.x(), across.y(), ray.z);
  if (!direction.allFinite()) return {};
  return direction;
}

}  // namespace kawara::vision
