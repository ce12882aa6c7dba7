#pragma once
#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/expected.hpp"
#include "onboard/survey/calibration_file.hpp"
#include "vision/camera/camera_choice.hpp"

/// camera.yaml of a survey folder, as it is written. docs/survey_format.md is the page for people.
namespace kawara::survey {

/// The body's axes, in which mountings and roll, pitch, yaw are given.
enum class BodyAxes { kForwardRightDown, kForwardLeftUp };
constexpr auto ConfigNames(BodyAxes) {
  using core::config::EnumName;
  return std::array{EnumName<BodyAxes>{BodyAxes::kForwardRightDown, "forward-right-down"},
                    EnumName<BodyAxes>{BodyAxes::kForwardLeftUp, "forward-left-up"}};
}

/// The camera's axes in a quaternion or matrix: vision/camera/optical_axis.hpp.
enum class CameraAxes { kOptical, kKawara };
constexpr auto ConfigNames(CameraAxes) {
  using core::config::EnumName;
  return std::array{EnumName<CameraAxes>{CameraAxes::kOptical, "optical"},
                    EnumName<CameraAxes>{CameraAxes::kKawara, "kawara"}};
}

/// Which edge of the picture is exposed first, by where the readout goes from there.
enum class Readout { kDown, kUp, kRight, kLeft };
constexpr auto ConfigNames(Readout) {
  using core::config::EnumName;
  return std::array{
      EnumName<Readout>{Readout::kDown, "down"}, EnumName<Readout>{Readout::kUp, "up"},
      EnumName<Readout>{Readout::kRight, "right"}, EnumName<Readout>{Readout::kLeft, "left"}};
}

/// How the camera sits in the body: a translation and ONE of the three ways to write a rotation.
struct MountingConfig {
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();  ///< of the viewpoint, in body axes
  /// How an upright camera that looks ahead is turned: ZYX in body axes.
  double roll_deg = 0.0, pitch_deg = 0.0, yaw_deg = 0.0;
  std::optional<std::array<double, 4>> quaternion_wxyz;  ///< takes camera axes to body axes
  /// Four rows of four; its translation takes the place of translation_m.
  std::vector<std::vector<double>> body_from_camera;
  CameraAxes axes = CameraAxes::kOptical;

  template <class V>
  void Visit(V& v) {
    using core::config::Optional;
    using core::config::Range;
    v("translation_m", translation_m, Range{-100, 100}, Optional{});
    v("roll_deg", roll_deg, Range{-360, 360}, Optional{});
    v("pitch_deg", pitch_deg, Range{-360, 360}, Optional{});
    v("yaw_deg", yaw_deg, Range{-360, 360}, Optional{});
    v("quaternion_wxyz", quaternion_wxyz);
    v("body_from_camera", body_from_camera, Optional{});
    v("axes", axes, Optional{});
    const bool angles = roll_deg != 0.0 || pitch_deg != 0.0 || yaw_deg != 0.0;
    v.Require(
        (angles ? 1 : 0) + (quaternion_wxyz ? 1 : 0) + (body_from_camera.empty() ? 0 : 1) <= 1,
        "body_from_camera", "one rotation: angles, or quaternion_wxyz, or body_from_camera");
  }
};

struct CameraConfig {
  std::string name;
  vision::CameraChoice optics;     ///< optics.camera empty: see calibration
  std::string calibration;         ///< a calibration program's file, relative to the survey
  std::string calibration_camera;  ///< which camera of it; empty: the one of the same name
  OpenCvModel calibration_as = OpenCvModel::kAuto;
  int width_px = 0;  ///< for calibrations that do not say
  int height_px = 0;
  bool mirrored = false;  ///< over the calibration
  vision::OpticalAxis axis = vision::OpticalAxis::kForward;
  std::string frames;  ///< folder or folder/pattern with * and ?; empty: see the page
  std::optional<MountingConfig> mounting;
  double line_delay_s = 0.0;
  Readout readout = Readout::kDown;
  double time_offset_s = 0.0;
  std::string mask;
  bool scale_to_picture = false;

  template <class V>
  void Visit(V& v) {
    using core::config::Optional;
    using core::config::Range;
    v("name", name, Optional{});
    v("camera", optics.camera, vision::CameraChoice::Names(), Optional{});
    optics.VisitSections([&](const char* key, auto& section) { v(key, section, Optional{}); });
    v("calibration", calibration, Optional{});
    v("calibration_camera", calibration_camera, Optional{});
    v("calibration_as", calibration_as, Optional{});
    v("width_px", width_px, Range{2, 65500}, Optional{});
    v("height_px", height_px, Range{2, 65500}, Optional{});
    v("mirrored", mirrored, Optional{});
    v("axis", axis, Optional{});
    v("frames", frames, Optional{});
    v("mounting", mounting);
    v("line_delay_s", line_delay_s, Range{0, 0.01}, Optional{});
    v("readout", readout, Optional{});
    v("time_offset_s", time_offset_s, Range{-10, 10}, Optional{});
    v("mask", mask, Optional{});
    v("scale_to_picture", scale_to_picture, Optional{});
  }
};

struct SurveyConfig {
  BodyAxes body_axes = BodyAxes::kForwardRightDown;
  std::vector<CameraConfig> cameras;
};

/// `text` of camera.yaml: one camera's keys, or `cameras:` with a list of them; `body_axes` beside
/// either. Errors: all mistakes, a line each, as "source:line:column: what".
core::Expected<SurveyConfig> ParseSurveyConfig(std::string_view text, const std::string& source);

/// Rotation and translation of a mounting, to the camera frame of camera_model.hpp. `axis` is the
/// model's. kInvalidArgument: no rotation.
core::Expected<Eigen::Isometry3d> BodyFromCamera(const MountingConfig& mounting, BodyAxes body,
                                                 vision::OpticalAxis axis);

/// The axis of the model chosen; a doughnut's is up, a panorama's forward.
vision::OpticalAxis AxisOf(const vision::CameraChoice& optics);

}  // namespace kawara::survey
