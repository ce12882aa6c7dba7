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
};

/// Takes directions of an upright, forward looking camera to body axes (forward, right, down).
inline Eigen::Matrix3d BodyFromCamera() {
  Eigen::Matrix3d R_body_camera;
  R_body_camera << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  return R_body_camera;
}

}  // namespace kawara::vision
