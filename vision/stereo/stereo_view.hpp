#pragma once
#include <Eigen/Geometry>

#include "vision/image.hpp"
#include "vision/stereo/stereo_camera.hpp"

namespace kawara::vision {

/// A picture, the camera it is of, and where that was. Refers to both.
struct StereoView {
  const StereoCamera* camera = nullptr;
  ConstImageView picture;
  Eigen::Isometry3d map_from_camera = Eigen::Isometry3d::Identity();
};

}  // namespace kawara::vision
