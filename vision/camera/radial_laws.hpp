#pragma once
#include <vector>

#include "vision/camera/lens_law.hpp"
#include "vision/camera/odd_polynomial.hpp"

/// The formulas of the lens models. `max_angle_rad` is the user's cut; the domain may end before.
namespace kawara::vision {

/// radius = a + k1 a^3 + k2 a^5 + k3 a^7 + k4 a^9, a the angle to the axis. Without k the
/// equidistant lens. Source: Kannala and Brandt, "A generic camera model and calibration method for
/// conventional, wide-angle, and fish-eye lenses", PAMI 2006, eq. (6) with k1 in the focal length;
/// OpenCV's cv::fisheye and Kalibr's "equidistant" are the same.
class KannalaBrandtLaw final : public RadialLaw {
 public:
  KannalaBrandtLaw(const OddPolynomial& radius_of_angle, double max_angle_rad);
  double Radius(const AxialRay& ray) const override;

 private:
  AxialRay Ray(double radius) const override;
  OddPolynomial radius_of_angle_;
};

/// The ray of a point at radius r px is (r, F(r)) with F a polynomial, F(0) > 0. Source: Scaramuzza
/// et al., "A toolbox for easily calibrating omnidirectional cameras", IROS 2006, eq. (6). Rays to
/// pixels by solving it, so that both ways agree to rounding; the second polynomial of a
/// calib_results.txt is only a fit to that solution.
class OcamLaw final : public RadialLaw {
 public:
  /// From a0 on, in px; the sign OCamCalib writes (its z axis points out of the scene) or the
  /// other. a0 must not be zero.
  OcamLaw(std::vector<double> polynomial, double max_angle_rad);
  double Radius(const AxialRay& ray) const override;

 private:
  AxialRay Ray(double radius) const override;
  double Depth(double radius) const;
  double DepthSlope(double radius) const;
  std::vector<double> polynomial_;
  double solvable_radius_ = 0.0;  ///< the angle grows with the radius up to here
};

/// Unified model for mirrors and fisheyes: the unit sphere seen from a point `xi` behind its
/// centre, then the odd polynomial k on the radius (k4 is not used). Source: Mei and Rives, "Single
/// view point omnidirectional camera calibration from planar grids", ICRA 2007. With xi = 0 the
/// pinhole.
class UnifiedLaw final : public RadialLaw {
 public:
  UnifiedLaw(double xi, const OddPolynomial& distortion, double max_angle_rad);
  double Radius(const AxialRay& ray) const override;
  /// Before distortion. Not finite at and beyond the angle that has no image.
  double UndistortedRadius(const AxialRay& ray) const;
  /// Inverse of UndistortedRadius.
  AxialRay Lift(double undistorted_radius) const;
  double max_undistorted_radius() const { return max_undistorted_radius_; }
  const OddPolynomial& distortion() const { return distortion_; }

 private:
  AxialRay Ray(double radius) const override;
  double xi_;
  OddPolynomial distortion_;
  double max_undistorted_radius_ = 0.0;
};

/// Extended unified model. Source: Khomutenko et al., "An enhanced unified camera model", RA-L
/// 2016; inverse as in Usenko et al., "The double sphere camera model", 3DV 2018, section 2.3.
class ExtendedUnifiedLaw final : public RadialLaw {
 public:
  /// 0 <= alpha <= 1, beta > 0.
  ExtendedUnifiedLaw(double alpha, double beta, double max_angle_rad);
  double Radius(const AxialRay& ray) const override;

 private:
  AxialRay Ray(double radius) const override;
  double alpha_, beta_;
};

/// Double Sphere. Source: Usenko et al., "The double sphere camera model", 3DV 2018, section 3.
class DoubleSphereLaw final : public RadialLaw {
 public:
  /// -1 < xi <= 1, 0 <= alpha <= 1.
  DoubleSphereLaw(double xi, double alpha, double max_angle_rad);
  double Radius(const AxialRay& ray) const override;

 private:
  AxialRay Ray(double radius) const override;
  double xi_, alpha_;
};

}  // namespace kawara::vision
