#pragma once
#include <Eigen/Core>
#include <optional>

#include "core/geodesy.hpp"

namespace kawara::vision {

/// Elevations above the camera's own horizon plane [rad]; bottom <= top.
struct ElevationRange {
  double bottom_rad = -core::kPi / 2;
  double top_rad = core::kPi / 2;
};

/// What a camera is that looks the same turned about its optical axis: with (x, y, z) the unit ray
/// in the OPTICAL frame,
///   pixel = center_px + affine * (x, y) * g(z),
/// g being whatever Project makes of it (radial_projection.hpp tabulates it).
struct RadialSymmetry {
  /// OPTICAL FRAME: z along the axis the picture's centre looks along, x and y across it.
  Eigen::Matrix3d R_optical_camera = Eigen::Matrix3d::Identity();
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();
  Eigen::Matrix2d affine = Eigen::Matrix2d::Identity();  ///< handedness and aspect are in here
  double z_min = -1.0;                                   ///< rays seen have z_min <= z <= z_max
  double z_max = 1.0;
};

/// A central camera: every pixel looks along one ray from one point. Immutable after construction;
/// any thread.
///
/// CAMERA FRAME, for all models, that of the paper's eq. (3), M = J [sin phi, cos phi sin theta,
/// cos phi cos theta]:
///   X up     along the mirror's axis; phi is the elevation above the plane X = 0,
///   Y right  theta = +90 deg,
///   Z forward theta = 0; theta grows to the right, clockwise seen from above, as a compass does.
/// Right-handed: X x Y = Z. A camera mounted upright and looking ahead relates to the body's
/// forward-right-down axes by BodyFromCamera(): forward = Z, right = Y, down = -X.
///
/// PIXELS: u to the right, v down, the CENTRE of the first pixel of the first row is (0, 0); the
/// picture covers
/// [-0.5, width - 0.5) x [-0.5, height - 0.5).
class CameraModel {
 public:
  virtual ~CameraModel() = default;

  virtual int width_px() const = 0;
  virtual int height_px() const = 0;

  /// Pixel (u, v) that sees the direction `ray_camera` (any length but zero).
  /// Empty: outside the field of view. The pixel may lie outside the picture if the field of view
  /// does.
  virtual std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& ray_camera) const = 0;

  /// Unit ray of a pixel. Empty: the pixel sees nothing valid. Inverse of Project within rounding.
  virtual std::optional<Eigen::Vector3d> Unproject(const Eigen::Vector2d& pixel_px) const = 0;

  /// Elevations the camera sees at least somewhere; the natural crop of its panorama.
  virtual ElevationRange Elevations() const = 0;

  /// Empty: not symmetric about any axis.
  virtual std::optional<RadialSymmetry> Symmetry() const { return {}; }
};

/// Takes directions of an upright, forward looking camera to body axes (forward, right, down).
inline Eigen::Matrix3d BodyFromCamera() {
  Eigen::Matrix3d R_body_camera;
  R_body_camera << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  return R_body_camera;
}

}  // namespace kawara::vision
