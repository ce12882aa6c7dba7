#pragma once
#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "onboard/survey/picture_file.hpp"
#include "onboard/survey/pose_table.hpp"
#include "onboard/survey/survey_config.hpp"
#include "vision/camera/camera_model.hpp"

namespace kawara::survey {

struct SurveyCamera {
  std::string name;  ///< empty for a single camera without one
  std::shared_ptr<const vision::CameraModel> model;
  /// To the body that the poses are of, from the camera frame of camera_model.hpp.
  Eigen::Isometry3d body_from_camera = Eigen::Isometry3d::Identity();
  double line_delay_s = 0.0;  ///< between neighbouring rows (columns) of a rolling shutter
  Readout readout = Readout::kDown;
  double time_offset_s = 0.0;  ///< exposure of the first row = the pose's stamp + this
  /// A byte a pixel, 0: not to be used (the robot's own body). Empty: all is.
  std::vector<std::uint8_t> mask;
};

struct SurveyFrame {
  int camera = 0;              ///< which of Survey::cameras
  std::filesystem::path file;  ///< the picture
  std::string name;            ///< the file's name without its ending
  PoseRow pose;                ///< moved on by the camera's time offset
};

/// A folder of anyone's pictures with poses, ready for work without time: docs/survey_format.md
/// says what may be in it. kawara-sim --render writes such folders.
struct Survey {
  std::vector<SurveyCamera> cameras;
  std::vector<SurveyFrame> frames;  ///< in the order of the poses, then of the cameras
  /// Of the map, whose axes are east, north, up there. Empty: the map is the poses' own frame.
  std::optional<core::Geodetic> origin;
  int pictures_without_pose = 0;
  int poses_without_picture = 0;
};

/// Errors: one line of what, where and how to mend it (of camera.yaml: a line for every mistake).
/// Pictures without pose and poses without picture are counted; none that fit is an error.
/// `origin`: of the map, where poses are geodetic; not given: the first pose's place.
core::Expected<Survey> OpenSurvey(const std::filesystem::path& folder,
                                  const std::optional<core::Geodetic>& origin = {});

/// What people call a frame: its name, after the camera's and a '/' where there are several.
std::string FullNameOf(const Survey& survey, const SurveyFrame& frame);

/// The frame's picture. Errors: LoadPicture's; kFormat if its size is not the camera's.
core::Expected<Picture> LoadFrame(const Survey& survey, const SurveyFrame& frame);

}  // namespace kawara::survey
