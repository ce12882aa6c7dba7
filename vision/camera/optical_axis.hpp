#pragma once
#include <Eigen/Core>
#include <array>

#include "core/config/constraints.hpp"

/// The one place where calibrations meet this project's frames.
///
/// The world gives calibrations in the OPTICAL FRAME: x to the right in the picture, y down, z
/// along the optical axis into the scene. This project's CAMERA FRAME (camera_model.hpp) has X up,
/// Y right, Z forward: the axes of an upright camera that looks ahead. Which of them the optical
/// axis is, a model says by its `axis`:
///
///   axis      optical z   picture's right (x)   picture's down (y)   who
///   forward   Z           Y                     -X                   a lens, a fisheye, as mounted
///   up        X           -Y                    -Z                   a mirror camera; a fisheye on
///                                                                    its back: top = forward
///   down      -X          Y                     -Z                   a fisheye hanging: top = fwd
///
/// All three are rotations. A picture seen through one mirror more than its calibration knows is
/// `mirrored`: its columns run the other way, so x changes sign before the lens does its part.
namespace kawara::vision {

enum class OpticalAxis { kForward, kUp, kDown };

constexpr auto ConfigNames(OpticalAxis) {
  using core::config::EnumName;
  return std::array{EnumName<OpticalAxis>{OpticalAxis::kForward, "forward"},
                    EnumName<OpticalAxis>{OpticalAxis::kUp, "up"},
                    EnumName<OpticalAxis>{OpticalAxis::kDown, "down"}};
}

/// Takes directions of the optical frame to the camera frame; a rotation.
inline Eigen::Matrix3d CameraFromOptical(OpticalAxis axis) {
  Eigen::Matrix3d R_camera_optical;  // columns: the optical axes x, y, z in camera axes
  switch (axis) {
    case OpticalAxis::kForward:
      R_camera_optical << 0, -1, 0, 1, 0, 0, 0, 0, 1;
      break;
    case OpticalAxis::kUp:
      R_camera_optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
      break;
    case OpticalAxis::kDown:
      R_camera_optical << 0, 0, -1, 1, 0, 0, 0, -1, 0;
      break;
  }
  return R_camera_optical;
}

}  // namespace kawara::vision
