#pragma once
#include <Eigen/Geometry>

#include "vision/image.hpp"
#include "vision/stereo/range_image.hpp"
#include "vision/voxel/camera_rays.hpp"

namespace kawara::vision {

/// One distance image and where it was taken. Owns nothing.
struct RangeView {
  const CameraRays& rays;
  const RangeImage& ranges;  ///< of the camera of `rays`
  ConstImageView picture;    ///< same size; empty: votes have no colour
  Eigen::Isometry3d map_from_camera = Eigen::Isometry3d::Identity();
  /// What the pose itself may be off by: the floor under every vote's deviation.
  double position_sd_m = 0.01;
  double attitude_sd_rad = 0.0005;
};

}  // namespace kawara::vision
