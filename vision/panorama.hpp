#pragma once
#include <memory>

#include "core/config/constraints.hpp"
#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "vision/camera/equirectangular_camera.hpp"
#include "vision/image.hpp"
#include "vision/remap_table.hpp"

namespace kawara::vision {

/// How the panorama is drawn. Angles in degrees: these are a configuration file's lines.
struct PanoramaConfig {
  int width_px =
      3000;  ///< full circle; rows follow from the elevations at the same pixels per degree
  /// Crop in elevation; both zero: what the camera sees.
  double elevation_top_deg = 0.0;
  double elevation_bottom_deg = 0.0;
  /// How the camera stands in the body: roll, pitch, yaw of an upright, forward looking camera,
  /// ZYX.
  double mount_roll_deg = 0.0;
  double mount_pitch_deg = 0.0;
  double mount_yaw_deg = 0.0;
  /// Turn the picture level by the pose's roll and pitch. Otherwise GPano's PosePitch/PoseRoll tell
  /// the viewer.
  bool level = false;
  /// Image centre = true north instead of body forward.
  bool north_up = false;
  int threads = 1;

  template <class V>
  void Visit(V& v) {
    using core::config::Optional;
    using core::config::Range;
    v("width_px", width_px, Range{64, 32768});
    v("elevation_top_deg", elevation_top_deg, Range{-90, 90}, Optional{});
    v("elevation_bottom_deg", elevation_bottom_deg, Range{-90, 90}, Optional{});
    v("mount_roll_deg", mount_roll_deg, Range{-180, 180}, Optional{});
    v("mount_pitch_deg", mount_pitch_deg, Range{-90, 90}, Optional{});
    v("mount_yaw_deg", mount_yaw_deg, Range{-360, 360}, Optional{});
    v("level", level, Optional{});
    v("north_up", north_up, Optional{});
    v("threads", threads, Range{1, 64}, Optional{});
  }
};

/// Unwraps pictures of any camera (the doughnut first of all) into an equirectangular panorama,
/// full circle, cropped in elevation; what the camera does not see is black. The image centre is
/// BODY FORWARD unless configured otherwise (EquirectangularCamera says how columns and rows run):
/// left in the picture is left of the robot.
///
/// The table is computed by Create (some 0.4 s of one core for 2 Mpx, a quarter more for planes);
/// Unwrap only follows it. With `level` or `north_up` SetAttitude computes it anew, which costs
/// that time again: viewers do the same from the GPano tags for nothing, so both are off by
/// default. One thread at a time.
class PanoramaUnwrapper {
 public:
  /// `format`: kRgb for Unwrap, kPlane for UnwrapYuv420. kInvalidArgument: odd or absurd width,
  /// empty crop.
  static core::Expected<PanoramaUnwrapper> Create(std::shared_ptr<const CameraModel> camera,
                                                  const PanoramaConfig& config,
                                                  RemapFormat format = RemapFormat::kRgb);

  const PanoramaGeometry& geometry() const { return target_.geometry(); }
  const RemapTable& table() const { return table_; }  ///< of RGB, or of luma

  /// Body attitude of the next picture. Does nothing unless `level` or `north_up` is on.
  core::Expected<void> SetAttitude(const core::Attitude& body);

  /// Attitude of the PICTURE: what GPano's PoseHeading, PosePitch and PoseRoll have to say if the
  /// body stood as `body` and the table was made for it. Follows from R_ned_body and what the table
  /// already turned.
  core::Attitude PictureAttitude(const core::Attitude& body) const;

  /// For RemapFormat::kRgb. `panorama` must have geometry()'s size and `picture` the camera's
  /// (CORE_CHECK).
  void Unwrap(const ConstImageView& picture, const ImageView& panorama) const;
  /// For RemapFormat::kPlane, likewise. The panorama's margin stays as it is.
  void UnwrapYuv420(const ConstYuv420View& picture, const Yuv420View& panorama) const;

 private:
  PanoramaUnwrapper(std::shared_ptr<const CameraModel> camera, const PanoramaConfig& config,
                    RemapFormat format, EquirectangularCamera target);
  core::Expected<void> BuildTable();

  std::shared_ptr<const CameraModel> camera_;
  PanoramaConfig config_;
  RemapFormat format_;
  EquirectangularCamera target_;
  Eigen::Matrix3d R_body_mount_;    ///< the camera's body-like axes in the body
  Eigen::Matrix3d R_body_picture_;  ///< the panorama's forward-right-down axes in the body
  RemapTable table_;
  RemapTable chroma_table_;  ///< kPlane: of both chroma planes
};

}  // namespace kawara::vision
