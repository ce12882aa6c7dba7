#include "onboard/survey/survey_config.hpp"

#include <Eigen/Geometry>
#include <set>

#include "core/config/config.hpp"
#include "onboard/survey/node_reading.hpp"

namespace kawara::survey {
namespace {

CameraConfig NoCamera() {
  CameraConfig config;
  config.optics.camera.clear();
  return config;
}

struct OneCamera {
  BodyAxes body_axes = BodyAxes::kForwardRightDown;
  CameraConfig camera = NoCamera();

  template <class V>
  void Visit(V& v) {
    v("body_axes", body_axes, core::config::Optional{});
    camera.Visit(v);
  }
};

struct Element : CameraConfig {
  Element() : CameraConfig(NoCamera()) {}
};

struct ManyCameras {
  BodyAxes body_axes = BodyAxes::kForwardRightDown;
  std::vector<Element> cameras;

  template <class V>
  void Visit(V& v) {
    v("body_axes", body_axes, core::config::Optional{});
    v("cameras", cameras, core::config::NotEmpty{});
  }
};

core::Expected<void> Judge(const SurveyConfig& config, const std::string& source) {
  std::set<std::string> names;
  for (const CameraConfig& camera : config.cameras) {
    const auto wrong = [&](const std::string& what) {
      return core::Fail(
          core::ErrorCode::kFormat,
          source + (camera.name.empty() ? "" : ": camera " + camera.name) + ": " + what);
    };
    if (config.cameras.size() > 1 && camera.name.empty()) {
      return wrong("cameras: expected a name for every one of several");
    }
    if (!camera.name.empty() && !names.insert(camera.name).second) {
      return wrong("there is another camera of this name");
    }
    if (camera.name.find('/') != std::string::npos) return wrong("name: expected no '/'");
    if (camera.optics.camera.empty() == camera.calibration.empty()) {
      return wrong("expected either camera: MODEL with its section, or calibration: FILE");
    }
    if (camera.calibration.empty() && (camera.width_px != 0 || camera.height_px != 0)) {
      return wrong("width_px, height_px stand in the model's section, beside calibration: only");
    }
    if (camera.calibration.empty() &&
        (camera.mirrored || camera.axis != vision::OpticalAxis::kForward)) {
      return wrong("mirrored, axis stand in the model's section, beside calibration: only");
    }
  }
  return {};
}

Eigen::Matrix3d Turned(double roll_deg, double pitch_deg, double yaw_deg) {
  return core::RotationNedFromBody(
      {roll_deg * core::kRadFromDeg, pitch_deg * core::kRadFromDeg, yaw_deg * core::kRadFromDeg});
}

}  // namespace

core::Expected<SurveyConfig> ParseSurveyConfig(std::string_view text, const std::string& source) {
  core::config::Problems ignored;
  const Node root = core::config::ParseYaml(text, source, ignored);
  SurveyConfig config;
  if (root.kind == Node::Kind::kMap && root.Find("cameras") != nullptr) {
    const auto many = core::config::Parse<ManyCameras>(text, source);
    if (!many) return tl::unexpected(many.error());
    config.body_axes = many->body_axes;
    config.cameras.assign(many->cameras.begin(), many->cameras.end());
  } else {
    const auto one = core::config::Parse<OneCamera>(text, source);
    if (!one) return tl::unexpected(one.error());
    config.body_axes = one->body_axes;
    config.cameras.push_back(one->camera);
  }
  if (auto good = Judge(config, source); !good) return tl::unexpected(good.error());
  return config;
}

vision::OpticalAxis AxisOf(const vision::CameraChoice& optics) {
  if (optics.camera == "doughnut") return vision::OpticalAxis::kUp;
  if (optics.camera == "equidistant") return optics.equidistant.common.axis;
  if (optics.camera == "kb4") return optics.kb4.common.axis;
  if (optics.camera == "ocam") return optics.ocam.common.axis;
  if (optics.camera == "mei") return optics.mei.common.axis;
  if (optics.camera == "eucm") return optics.eucm.common.axis;
  if (optics.camera == "double_sphere") return optics.double_sphere.common.axis;
  return vision::OpticalAxis::kForward;
}

core::Expected<Eigen::Isometry3d> BodyFromCamera(const MountingConfig& mounting, BodyAxes body,
                                                 vision::OpticalAxis axis) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = mounting.translation_m;
  // From what a quaternion or matrix calls camera axes to ours.
  const Eigen::Matrix3d R_given_camera = mounting.axes == CameraAxes::kKawara
                                             ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                                             : vision::CameraFromOptical(axis).transpose();
  if (mounting.quaternion_wxyz) {
    const auto& q = *mounting.quaternion_wxyz;
    const auto rotation = QuaternionOf(q[0], q[1], q[2], q[3]);
    if (!rotation) {
      return core::Fail(core::ErrorCode::kInvalidArgument,
                        "mounting.quaternion_wxyz: " + rotation.error().message);
    }
    pose.linear() = rotation->toRotationMatrix() * R_given_camera;
    return pose;
  }
  if (!mounting.body_from_camera.empty()) {
    std::vector<double> rows;
    for (const auto& row : mounting.body_from_camera)
      rows.insert(rows.end(), row.begin(), row.end());
    auto transform = TransformOf(rows, Node{});
    if (!transform) {
      return core::Fail(core::ErrorCode::kInvalidArgument,
                        "mounting.body_from_camera: expected four rows of four numbers: a "
                        "rotation, a translation, 0 0 0 1");
    }
    transform->linear() = (transform->linear() * R_given_camera).eval();
    return *transform;
  }
  Eigen::Matrix3d R_body_upright = vision::BodyFromCamera();  // to forward, right, down
  if (body == BodyAxes::kForwardLeftUp) {
    R_body_upright = (Eigen::Vector3d(1, -1, -1).asDiagonal() * R_body_upright).eval();
  }
  pose.linear() = Turned(mounting.roll_deg, mounting.pitch_deg, mounting.yaw_deg) * R_body_upright;
  return pose;
}

}  // namespace kawara::survey
