#pragma once
#include <Eigen/Geometry>
#include <functional>
#include <string>
#include <vector>

#include "core/expected.hpp"

namespace kawara::calibrate {

struct MountingOptions {
  std::string survey;          ///< folder with pictures, poses and camera.yaml
  std::string out;             ///< mounting.yaml
  double step_m = 0.28;        ///< between frames that are used
  double believed_deg = 2.0;   ///< how well camera.yaml's mounting is known, each axis, 1 sigma
  double wanted_sd_deg = 0.2;  ///< an axis known worse than this is refused
};

struct CameraMounting {
  std::string name;  ///< the camera's; empty: the only one
  Eigen::Isometry3d body_from_camera = Eigen::Isometry3d::Identity();
};

struct MountingResult {
  std::vector<CameraMounting> cameras;  ///< the rig is turned as a whole
  /// Turn from camera.yaml's mounting about the body's axes, in the survey's body axes [rad].
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d turn_sd_rad = Eigen::Vector3d::Zero();
  double time_offset_s = 0.0, time_offset_sd_s = 0.0;
  double residual_px = 0.0;  ///< of corners followed, robust
  int frames = 0;
  double way_m = 0.0;
};

/// How the camera rig is turned against the body that the poses are of: corners are followed
/// through the pictures of a drive, and their epipolar geometry must fit RTK/INS motion
/// (vision/refine). Repeated from the mounting found until it stays. A constant error of the poses'
/// attitude is part of the answer: the mounting is against the body AS THE POSES SAY. Translations
/// are taken as given. Errors, one line: of the survey; kFormat: a drive that does not determine
/// the mounting, with the axes and their deviations.
core::Expected<MountingResult> RunMounting(const MountingOptions& options,
                                           const std::function<void(const std::string&)>& say);

}  // namespace kawara::calibrate
