#include "vision/camera/radial_laws.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "core/check.hpp"

namespace kawara::vision {
namespace {

constexpr double kNoImage = std::numeric_limits<double>::quiet_NaN();
// OCam polynomials are looked at up to this many times a0 from the centre: 89 deg of a pinhole.
constexpr double kOcamReach = 64.0;
constexpr int kOcamStepsPerFocal = 256;

AxialRay Normalised(double rho, double z) {
  const double length = std::hypot(rho, z);
  return {rho / length, z / length};
}

double Ratio(double rho, double denominator) {
  return denominator > 0.0 ? rho / denominator : kNoImage;
}

}  // namespace

KannalaBrandtLaw::KannalaBrandtLaw(const OddPolynomial& radius_of_angle, double max_angle_rad)
    : radius_of_angle_(radius_of_angle) {
  FindDomain(max_angle_rad);
}

double KannalaBrandtLaw::Radius(const AxialRay& ray) const {
  return radius_of_angle_.Value(std::atan2(ray.rho, ray.z));
}

AxialRay KannalaBrandtLaw::Ray(double radius) const {
  const double angle = radius_of_angle_.Solve(radius, 0.0, max_angle_rad());
  return {std::sin(angle), std::cos(angle)};
}

OcamLaw::OcamLaw(std::vector<double> polynomial, double max_angle_rad)
    : polynomial_(std::move(polynomial)) {
  CORE_CHECK(!polynomial_.empty() && polynomial_[0] != 0.0);
  if (polynomial_[0] < 0.0) {
    for (double& a : polynomial_) a = -a;
  }
  // The angle atan2(r, F) grows while F - r F' > 0.
  const double step = polynomial_[0] / kOcamStepsPerFocal;
  for (int i = 1; i <= kOcamReach * kOcamStepsPerFocal; ++i) {
    const double r = i * step;
    if (!(Depth(r) - r * DepthSlope(r) > 0.0)) break;
    solvable_radius_ = r;
  }
  FindDomain(max_angle_rad);
}

double OcamLaw::Depth(double radius) const {
  double sum = 0.0;
  for (auto a = polynomial_.rbegin(); a != polynomial_.rend(); ++a) sum = sum * radius + *a;
  return sum;
}

double OcamLaw::DepthSlope(double radius) const {
  double sum = 0.0;
  for (std::size_t i = polynomial_.size() - 1; i >= 1; --i) {
    sum = sum * radius + static_cast<double>(i) * polynomial_[i];
  }
  return sum;
}

// rho F(r) - z r falls through zero at the radius asked for: Newton, kept in its bracket.
double OcamLaw::Radius(const AxialRay& ray) const {
  double low = 0.0, high = solvable_radius_;
  const auto excess = [&](double r) { return ray.rho * Depth(r) - ray.z * r; };
  if (excess(high) > 0.0) return kNoImage;
  double r = std::min(high, polynomial_[0] * std::atan2(ray.rho, ray.z));
  for (int i = 0; i < 100; ++i) {
    const double error = excess(r);
    if (error == 0.0) return r;
    (error > 0.0 ? low : high) = r;
    double next = r - error / (ray.rho * DepthSlope(r) - ray.z);
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const double moved = std::abs(next - r);
    r = next;
    if (moved <= 1e-16 * r) break;
  }
  return r;
}

AxialRay OcamLaw::Ray(double radius) const { return Normalised(radius, Depth(radius)); }

UnifiedLaw::UnifiedLaw(double xi, const OddPolynomial& distortion, double max_angle_rad)
    : xi_(xi), distortion_(distortion) {
  FindDomain(max_angle_rad);
  const double end_rad = this->max_angle_rad();
  max_undistorted_radius_ = UndistortedRadius({std::sin(end_rad), std::cos(end_rad)});
}

// With xi > 1 the sphere hides its own far side beyond cos = -1 / xi: the radius falls again, and
// FindDomain ends there. With xi <= 1 it grows without end towards cos = -xi.
double UnifiedLaw::UndistortedRadius(const AxialRay& ray) const {
  return Ratio(ray.rho, ray.z + xi_);
}

double UnifiedLaw::Radius(const AxialRay& ray) const {
  return distortion_.Value(UndistortedRadius(ray));
}

AxialRay UnifiedLaw::Lift(double undistorted_radius) const {
  const double s = undistorted_radius * undistorted_radius;
  const double root = std::sqrt(std::max(0.0, 1.0 + (1.0 - xi_ * xi_) * s));
  const double factor = (xi_ + root) / (s + 1.0);
  return Normalised(factor * undistorted_radius, factor - xi_);
}

AxialRay UnifiedLaw::Ray(double radius) const {
  return Lift(distortion_.Solve(radius, 0.0, max_undistorted_radius_));
}

ExtendedUnifiedLaw::ExtendedUnifiedLaw(double alpha, double beta, double max_angle_rad)
    : alpha_(alpha), beta_(beta) {
  FindDomain(max_angle_rad);
}

double ExtendedUnifiedLaw::Radius(const AxialRay& ray) const {
  const double d = std::sqrt(beta_ * ray.rho * ray.rho + ray.z * ray.z);
  return Ratio(ray.rho, alpha_ * d + (1.0 - alpha_) * ray.z);
}

AxialRay ExtendedUnifiedLaw::Ray(double radius) const {
  const double s = beta_ * radius * radius;
  const double root = std::sqrt(std::max(0.0, 1.0 - (2.0 * alpha_ - 1.0) * s));
  // (1 - alpha^2 s) / (alpha root + 1 - alpha), which is 0 / 0 where alpha and radius are one.
  return Normalised(radius * (alpha_ * root + 1.0 - alpha_), 1.0 - alpha_ * alpha_ * s);
}

DoubleSphereLaw::DoubleSphereLaw(double xi, double alpha, double max_angle_rad)
    : xi_(xi), alpha_(alpha) {
  FindDomain(max_angle_rad);
}

double DoubleSphereLaw::Radius(const AxialRay& ray) const {
  const double shifted = xi_ + ray.z;
  const double d2 = std::hypot(ray.rho, shifted);
  return Ratio(ray.rho, alpha_ * d2 + (1.0 - alpha_) * shifted);
}

AxialRay DoubleSphereLaw::Ray(double radius) const {
  const double s = radius * radius;
  const double root = std::sqrt(std::max(0.0, 1.0 - (2.0 * alpha_ - 1.0) * s));
  // The direction from the second sphere's centre, (radius, mz), over its denominator: as above.
  const double denominator = alpha_ * root + 1.0 - alpha_;
  const AxialRay second = Normalised(radius * denominator, 1.0 - alpha_ * alpha_ * s);
  // Back to the unit sphere around the first.
  const double along =
      xi_ * second.z + std::sqrt(std::max(0.0, 1.0 - xi_ * xi_ * second.rho * second.rho));
  return Normalised(along * second.rho, along * second.z - xi_);
}

}  // namespace kawara::vision
