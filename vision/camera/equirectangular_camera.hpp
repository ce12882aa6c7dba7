#pragma once
#include "core/expected.hpp"
#include "vision/camera/camera_model.hpp"

namespace kawara::vision {

/// Which part of the full sphere an equirectangular picture shows; the numbers are those of GPano
/// (Google Photo Sphere XMP: CroppedArea..., FullPano...). The full sphere is 2:1.
struct PanoramaGeometry {
  int width_px = 0;  ///< of the picture itself (the cropped area)
  int height_px = 0;
  int full_width_px = 0;  ///< of the whole sphere at the same scale
  int full_height_px = 0;
  int left_px = 0;  ///< where the picture sits in the sphere
  int top_px = 0;

  bool operator==(const PanoramaGeometry&) const = default;
  /// A picture of the full sphere.
  static PanoramaGeometry Full(int width_px, int height_px);
  /// Full circle in azimuth, rows that cover `elevations`; full sphere is width x width / 2.
  static PanoramaGeometry Band(int width_px, const ElevationRange& elevations);
  /// The same picture resized; the crop is kept to the nearest pixel.
  PanoramaGeometry Resized(int new_width_px) const;
};

/// Equirectangular picture, stitched by a 360 camera or made by this library. The CENTRE of the
/// full sphere's width is the camera's forward axis (Z), columns go to the right (+theta): column u
/// sees theta = ((left + u + 0.5) / full_width - 0.5) * 2 pi, row v sees phi = (0.5 - (top + v +
/// 0.5) / full_height) * pi. So column 0 of a full panorama looks backwards, and left of the centre
/// is left of the robot.
class EquirectangularCamera final : public CameraModel {
 public:
  /// kInvalidArgument: empty picture, or a crop that is not inside the sphere.
  static core::Expected<EquirectangularCamera> Create(const PanoramaGeometry& geometry);

  const PanoramaGeometry& geometry() const { return g_; }
  int width_px() const override { return g_.width_px; }
  int height_px() const override { return g_.height_px; }
  /// A ray in the half pixel beyond either edge column comes out in [-0.5, 0) or [width - 1, width
  /// - 0.5).
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& ray_camera) const override;
  std::optional<Eigen::Vector3d> Unproject(const Eigen::Vector2d& pixel_px) const override;
  ElevationRange Elevations() const override;

 private:
  explicit EquirectangularCamera(const PanoramaGeometry& geometry);
  PanoramaGeometry g_;
};

}  // namespace kawara::vision
