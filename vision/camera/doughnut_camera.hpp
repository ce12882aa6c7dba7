#pragma once
#include <array>

#include "core/config/constraints.hpp"
#include "core/expected.hpp"
#include "vision/camera/camera_model.hpp"
#include "vision/camera/odd_polynomial.hpp"
#include "vision/camera/optical_axis.hpp"

namespace kawara::vision {

/// What the calibration of an omnidirectional mirror camera says about its ring-shaped picture.
/// Source: Meguro et al., section 4B, Fig. 7 and eqs. (1)-(3).
struct DoughnutParameters {
  int width_px = 1024;
  int height_px = 1024;
  double center_u_px = 511.5;  ///< principal point: where the mirror's axis pierces the picture
  double center_v_px = 511.5;
  double l_in_px = 120.0;     ///< innermost circle of the ring, radius from the principal point
  double l_base_px = 262.5;   ///< base circle: the horizon, elevation zero
  double l_out_px = 500.0;    ///< outermost circle
  double phi_top_deg = 30.0;  ///< elevation on the INNER circle, as eq. (2) is written
  double phi_bottom_deg =
      -50.0;  ///< elevation on the OUTER circle. Swap the two for a mirror seen from below.
  double forward_deg = 0.0;  ///< image angle atan2(v, u) at which the camera's forward axis appears
  /// Handedness. false: going clockwise in the picture goes clockwise on the ground seen from above
  /// (a camera that looks down, or whose driver has already flipped the picture). true: the picture
  /// is a mirror image, as a camera looking up into a mirror makes it. Wrong here means every sign
  /// in the panorama reads backwards.
  bool mirrored = false;
  /// What a real mirror adds to eq. (2): with a the angle from the mirror's axis on the inner
  /// circle's side and P(a) = a + k1 a^3 + k2 a^5 + k3 a^7 + k4 a^9, the radius is linear in P(a)
  /// instead of in a. The circles and the horizon stay where the other numbers say.
  std::array<double, 4> correction{};
  double v_scale = 1.0;  ///< pixel aspect: rows per column of the same length on the sensor

  /// The same optics in a picture that the JPEG decoder reduced to eighths / 8 (1..8), sizes
  /// rounded up.
  DoughnutParameters Scaled(int eighths) const;
  /// The same optics in a picture of another size (another mode of the same sensor).
  DoughnutParameters Resized(int new_width_px, int new_height_px) const;

  template <class V>
  void Visit(V& v) {
    using core::config::Optional;
    using core::config::Range;
    v("width_px", width_px, Range{2, 65500});
    v("height_px", height_px, Range{2, 65500});
    v("center_u_px", center_u_px);
    v("center_v_px", center_v_px);
    v("l_in_px", l_in_px, Range{0, 65500});
    v("l_base_px", l_base_px);
    v("l_out_px", l_out_px, Range{1, 65500});
    v("phi_top_deg", phi_top_deg, Range{-90, 90});
    v("phi_bottom_deg", phi_bottom_deg, Range{-90, 90});
    v("forward_deg", forward_deg, Range{-360, 360}, Optional{});
    v("mirrored", mirrored, Optional{});
    v("correction", correction, Optional{});
    v("v_scale", v_scale, Range{0.1, 10}, Optional{});
  }
};

/// The paper's ODV model: elevation falls linearly with the radius,
///   phi = (phi_top - phi_bottom) / (L_out - L_in) * (L_base - r),   theta = atan2(v, u),
/// or with `correction` an odd polynomial's fall.
/// Field of view: L_in <= r <= L_out. A ray along the axis (X) is outside unless L_in is zero.
class DoughnutCamera final : public CameraModel {
 public:
  /// kInvalidArgument: sizes or radii out of order, L_base that contradicts phi_top and phi_bottom
  /// by more than a degree (the five numbers hold one too many, which catches a mistyped one).
  static core::Expected<DoughnutCamera> Create(const DoughnutParameters& parameters);

  const DoughnutParameters& parameters() const { return p_; }
  int width_px() const override { return p_.width_px; }
  int height_px() const override { return p_.height_px; }
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& ray_camera) const override;
  std::optional<Eigen::Vector3d> Unproject(const Eigen::Vector2d& pixel_px) const override;
  ElevationRange Elevations() const override;
  /// The optical axis is the mirror's: R_optical_camera of OpticalAxis::kUp.
  std::optional<RadialSymmetry> Symmetry() const override;

 private:
  explicit DoughnutCamera(const DoughnutParameters& parameters);
  double RadiusOf(double phi_rad) const;
  double ElevationAt(double r_px) const;

  DoughnutParameters p_;
  OddPolynomial correction_;  ///< P(a)
  double side_;               ///< +1: the inner circle is the upper one, a = pi/2 - phi; -1: + phi
  double px_per_unit_;        ///< of P(a)
  double rad_per_px_;  ///< the fraction of eq. (2); negative when the inner circle is the lower one
  double cos_forward_, sin_forward_;
};

}  // namespace kawara::vision
