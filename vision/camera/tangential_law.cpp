#include "vision/camera/tangential_law.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace kawara::vision {
namespace {

// A determinant smaller than this share of the undistorted one is about to fold.
constexpr double kLeastDeterminant = 1e-3;

}  // namespace

Eigen::Vector2d TangentialLaw::Distorted(const Eigen::Vector2d& m) const {
  const double r = m.norm();
  const double s = r * r;
  const double radial = r > 0.0 ? radial_.distortion().Value(r) / r : 1.0;
  const double xy = m.x() * m.y();
  return {m.x() * radial + 2.0 * p1_ * xy + p2_ * (s + 2.0 * m.x() * m.x()),
          m.y() * radial + p1_ * (s + 2.0 * m.y() * m.y()) + 2.0 * p2_ * xy};
}

Eigen::Matrix2d TangentialLaw::Jacobian(const Eigen::Vector2d& m) const {
  const double x = m.x(), y = m.y(), r = m.norm();
  const double radial = r > 0.0 ? radial_.distortion().Value(r) / r : 1.0;
  // d(radial) / d(r^2) = (slope - radial) / (2 r^2).
  const double change = r > 0.0 ? (radial_.distortion().Slope(r) - radial) / (r * r) : 0.0;
  Eigen::Matrix2d J;
  J << radial + change * x * x + 2.0 * p1_ * y + 6.0 * p2_ * x,
      change * x * y + 2.0 * p1_ * x + 2.0 * p2_ * y,
      change * x * y + 2.0 * p1_ * x + 2.0 * p2_ * y,
      radial + change * y * y + 6.0 * p1_ * y + 2.0 * p2_ * x;
  return J;
}

std::optional<Eigen::Vector2d> TangentialLaw::ToPlane(const Eigen::Vector3d& ray_optical) const {
  const double rho = std::hypot(ray_optical.x(), ray_optical.y());
  if (!(std::atan2(rho, ray_optical.z()) <= max_angle_rad() + 1e-12)) return {};
  if (rho == 0.0) {
    if (ray_optical.z() <= 0.0) return {};
    return Eigen::Vector2d(0.0, 0.0);
  }
  const Eigen::Vector2d m =
      ray_optical.head<2>() * (radial_.UndistortedRadius({rho, ray_optical.z()}) / rho);
  if (!(Jacobian(m).determinant() > kLeastDeterminant)) return {};
  return Distorted(m);
}

// Newton in two dimensions, from the solution without tangential terms.
std::optional<Eigen::Vector3d> TangentialLaw::ToRay(const Eigen::Vector2d& plane) const {
  const double radius = plane.norm();
  if (!std::isfinite(radius)) return {};
  const double limit = radial_.max_undistorted_radius();
  const double start = radial_.distortion().Solve(radius, 0.0, limit);
  Eigen::Vector2d m = radius > 0.0 ? Eigen::Vector2d(plane * (start / radius)) : plane;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Matrix2d J = Jacobian(m);
    if (!(J.determinant() > kLeastDeterminant)) return {};
    const Eigen::Vector2d step = J.inverse() * (plane - Distorted(m));
    m += step;
    if (!(step.norm() > 1e-15 * (1.0 + m.norm()))) break;
  }
  const double undistorted = m.norm();
  if (!(undistorted <= limit * (1.0 + 1e-12)) ||
      !((Distorted(m) - plane).norm() <= 1e-12 * (1.0 + radius))) {
    return {};
  }
  if (undistorted == 0.0) return Eigen::Vector3d(0.0, 0.0, 1.0);
  const AxialRay ray = radial_.Lift(std::min(undistorted, limit));
  const Eigen::Vector2d across = m * (ray.rho / undistorted);
  return Eigen::Vector3d(across.x(), across.y(), ray.z);
}

}  // namespace kawara::vision
