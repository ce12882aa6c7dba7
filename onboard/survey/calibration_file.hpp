#pragma once
#include <Eigen/Geometry>
#include <string>
#include <string_view>
#include <vector>

#include "core/expected.hpp"
#include "vision/camera/camera_choice.hpp"

namespace kawara::survey {

/// How an OpenCV file without a hint of its own is to be read.
enum class OpenCvModel { kAuto, kPinhole, kFisheye, kOmnidir };

constexpr auto ConfigNames(OpenCvModel) {
  using core::config::EnumName;
  return std::array{EnumName<OpenCvModel>{OpenCvModel::kAuto, "auto"},
                    EnumName<OpenCvModel>{OpenCvModel::kPinhole, "opencv-pinhole"},
                    EnumName<OpenCvModel>{OpenCvModel::kFisheye, "opencv-fisheye"},
                    EnumName<OpenCvModel>{OpenCvModel::kOmnidir, "opencv-omnidir"}};
}

/// One camera of a calibration program's file.
struct Calibration {
  std::string name;             ///< cam0, cam1 ... or empty
  vision::CameraChoice optics;  ///< picture size 0 x 0 where the file has none
  /// Takes points of the camera's OPTICAL frame to the body: the inertial unit's axes of the file,
  /// or without one the first camera's. Identity where the file has none.
  Eigen::Isometry3d body_from_optical = Eigen::Isometry3d::Identity();
  bool has_mounting = false;
  /// What is to be added to the picture's stamp to get the body's clock [s].
  double time_offset_s = 0.0;
};

/// Reads what calibration programs write; which of them is seen from the text:
///   OCamCalib  calib_results.txt (centre row, column from 0; the inverse polynomial may be
///   missing) Kalibr     camchain yaml: omni, eucm, ds, pinhole with radtan, equidistant, none;
///              T_cam_imu, T_cn_cnm1, timeshift_cam_imu
///   Basalt     calibration json: ds, eucm, kb4, pinhole; T_imu_cam, cam_time_offset_ns
///   OpenCV     yaml or json of cv::FileStorage, also of ROS: camera_matrix or K,
///              distortion_coefficients or D, xi. Without xi and without fisheye_model or
///              distortion_model, four coefficients may be of two models: `opencv` decides.
/// `source` stands before every message. Errors: kFormat, "source:line:column: what".
core::Expected<std::vector<Calibration>> ParseCalibration(std::string_view text,
                                                          const std::string& source,
                                                          OpenCvModel opencv = OpenCvModel::kAuto);

}  // namespace kawara::survey
