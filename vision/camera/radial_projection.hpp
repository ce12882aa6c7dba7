#pragma once
#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "vision/camera/camera_model.hpp"

namespace kawara::vision {

/// What RadialProjection computes with: a kernel that projects many rays at once repeats its
/// Project() on these. Refers to the RadialProjection it is of.
struct RadialTable {
  const float* knots = nullptr;  ///< g at z_min + i * step [px], i < count; the last is at z_max
  int count = 0;                 ///< at least 2
  float z_min = 0.0F;
  float z_max = 0.0F;
  float inverse_step = 0.0F;  ///< (count - 1) / (z_max - z_min)
  float center_u_px = 0.0F;
  float center_v_px = 0.0F;
  float affine[4] = {1.0F, 0.0F, 0.0F, 1.0F};  ///< rows: u of x, u of y, v of x, v of y
  int width_px = 0;
  int height_px = 0;
};

/// The fast way from rays to pixels for every camera that is symmetric about an axis, whatever its
/// model: a table of g(z) = (radius in the picture) / (distance of the unit ray's tip from the
/// axis), with z the ray's component along the axis,
///   pixel = center + affine * (x, y) * g(z),
/// linear between uniform knots. No square root, no angle. Immutable; any thread.
///
/// Valid are the rays the camera sees AND whose pixel could lie in its picture (z_min..z_max is
/// narrowed to the picture's farthest corner; rays more than 154 deg from the axis are left out).
class RadialProjection {
 public:
  /// Of the table alone, against the camera's own Project [px]; float arithmetic adds some 1e-4.
  static constexpr double kTableTolerancePx = 2e-4;
  static constexpr int kMaxKnots = 1 << 15;

  /// As many knots as the tolerance takes, at most kMaxKnots (128 KiB); see table_error_px().
  /// Empty: `camera` is not symmetric (equirectangular; lenses with tangential distortion), or sees
  /// nothing.
  static std::optional<RadialProjection> Create(const CameraModel& camera);

  RadialProjection(const RadialProjection& other);
  RadialProjection& operator=(const RadialProjection& other);
  RadialProjection(RadialProjection&& other) noexcept = default;
  RadialProjection& operator=(RadialProjection&& other) noexcept = default;
  ~RadialProjection() = default;

  const RadialTable& table() const { return table_; }
  std::span<const float> knots() const { return knots_; }
  /// Takes directions of the camera frame to the optical frame that Project() wants.
  const Eigen::Matrix3d& R_optical_camera() const { return R_optical_camera_; }
  /// The largest error of the table halfway between knots [px].
  double table_error_px() const { return table_error_px_; }

  /// Pixel of a UNIT ray in the OPTICAL frame. False: not seen, or outside [-0.5, size - 0.5).
  bool Project(float x, float y, float z, float* u_px, float* v_px) const {
    const RadialTable& t = table_;
    if (!(z >= t.z_min && z <= t.z_max)) return false;
    const float at = (z - t.z_min) * t.inverse_step;
    int knot = static_cast<int>(at);
    if (knot > t.count - 2) knot = t.count - 2;
    const float g =
        t.knots[knot] + (at - static_cast<float>(knot)) * (t.knots[knot + 1] - t.knots[knot]);
    const float u = t.center_u_px + g * (t.affine[0] * x + t.affine[1] * y);
    const float v = t.center_v_px + g * (t.affine[2] * x + t.affine[3] * y);
    *u_px = u;
    *v_px = v;
    return u >= -0.5F && u < static_cast<float>(t.width_px) - 0.5F && v >= -0.5F &&
           v < static_cast<float>(t.height_px) - 0.5F;
  }

 private:
  RadialProjection() = default;

  std::vector<float> knots_;
  RadialTable table_;  ///< points into knots_
  Eigen::Matrix3d R_optical_camera_ = Eigen::Matrix3d::Identity();
  double table_error_px_ = 0.0;
};

}  // namespace kawara::vision
