#pragma once
#include <Eigen/Core>
#include <optional>

namespace kawara::vision {

/// What a lens does before pixels: unit rays of the OPTICAL frame (optical_axis.hpp) to points of
/// a plane, x right, y down. Near the axis the plane's unit is one focal length (for OcamLaw: one
/// pixel). Immutable; any thread.
class LensLaw {
 public:
  virtual ~LensLaw() = default;
  /// Empty: outside the domain, see max_angle_rad().
  virtual std::optional<Eigen::Vector2d> ToPlane(const Eigen::Vector3d& ray_optical) const = 0;
  /// Unit ray of a point; inverse of ToPlane within rounding. Empty: no ray of the domain goes
  /// there.
  virtual std::optional<Eigen::Vector3d> ToRay(const Eigen::Vector2d& plane) const = 0;
  /// Does the radius in the plane depend on nothing but the angle to the axis?
  virtual bool IsSymmetric() const = 0;
  /// End of the domain: the law holds for rays up to this angle from the axis. Beyond, the formula
  /// folds back (two rays in one point), has no value, or was cut off by the user.
  virtual double max_angle_rad() const = 0;
};

/// A unit ray by its distance from the optical axis (sine of the angle) and along it (cosine).
struct AxialRay {
  double rho = 0.0;
  double z = 1.0;
};

/// A law that is symmetric about the axis: one function between angle and radius.
class RadialLaw : public LensLaw {
 public:
  std::optional<Eigen::Vector2d> ToPlane(const Eigen::Vector3d& ray_optical) const final;
  std::optional<Eigen::Vector3d> ToRay(const Eigen::Vector2d& plane) const final;
  bool IsSymmetric() const final { return true; }
  double max_angle_rad() const final { return max_angle_rad_; }
  double max_radius() const { return max_radius_; }

  /// The formula for any ray, in or out of the domain; not finite where it has no value.
  virtual double Radius(const AxialRay& ray) const = 0;

 protected:
  /// Inverse of Radius over [0, max_radius()].
  virtual AxialRay Ray(double radius) const = 0;
  /// Finds the domain, to be called at the end of construction: goes outwards in steps of 0.02 deg
  /// and ends before the first in which the radius grows less than a thousandth of what it does on
  /// the axis.
  void FindDomain(double wanted_max_angle_rad);

 private:
  double max_angle_rad_ = 0.0;
  double max_radius_ = 0.0;
};

}  // namespace kawara::vision
