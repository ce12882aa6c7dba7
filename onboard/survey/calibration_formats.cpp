#include "onboard/survey/calibration_formats.hpp"

#include <cmath>

namespace kawara::survey {
namespace {

using vision::CameraChoice;
using Numbers = std::vector<double>;

/// fu fv pu pv (Kalibr, OpenCV) with k1 k2 p1 p2 and perhaps k3, behind a mirror or not.
void SetMei(CameraChoice& optics, double xi, const double* focal, const Numbers& d) {
  optics.camera = "mei";
  vision::MeiParameters& mei = optics.mei;
  SetLens(mei.common, mei.focal, focal[0], focal[1], focal[2], focal[3]);
  mei.xi = xi;
  if (d.size() >= 4) {
    mei.k1 = d[0];
    mei.k2 = d[1];
    mei.p1 = d[2];
    mei.p2 = d[3];
  }
  if (d.size() >= 5) mei.k3 = d[4];
}

void SetKb4(CameraChoice& optics, const double* focal, const Numbers& k) {
  optics.camera = "kb4";
  SetLens(optics.kb4.common, optics.kb4.focal, focal[0], focal[1], focal[2], focal[3]);
  for (std::size_t i = 0; i < 4; ++i) optics.kb4.k[i] = k[i];
}

core::Expected<CameraChoice> KalibrOptics(const Node& cam) {
  CameraChoice optics;
  const auto model = Need(cam, "camera_model");
  const auto size = NeedNumbers(cam, "resolution", 2);
  if (!model) return tl::unexpected(model.error());
  if (!size) return tl::unexpected(size.error());
  const std::string& name = (*model)->text;
  const std::size_t extra = name == "omni" ? 1 : name == "eucm" || name == "ds" ? 2 : 0;
  if (extra == 0 && name != "pinhole") {
    return Wrong(**model,
                 "camera_model: " + (*model)->Shown() + ": expected omni, eucm, ds or pinhole");
  }
  const auto in = NeedNumbers(cam, "intrinsics", 4 + extra);
  if (!in) return tl::unexpected(in.error());
  std::string distortion = "none";
  Numbers d;
  if (const Node* node = cam.Find("distortion_model")) distortion = node->text;
  if (distortion != "none") {
    const auto coefficients = NeedNumbers(cam, "distortion_coeffs", 4);
    if (!coefficients) return tl::unexpected(coefficients.error());
    d = *coefficients;
  }
  const double* focal = in->data() + extra;
  const bool plain = distortion == "none";
  if (name == "eucm" && plain) {
    optics.camera = "eucm";
    SetLens(optics.eucm.common, optics.eucm.focal, focal[0], focal[1], focal[2], focal[3]);
    optics.eucm.alpha = (*in)[0];
    optics.eucm.beta = (*in)[1];
  } else if (name == "ds" && plain) {
    optics.camera = "double_sphere";
    auto& ds = optics.double_sphere;
    SetLens(ds.common, ds.focal, focal[0], focal[1], focal[2], focal[3]);
    ds.xi = (*in)[0];
    ds.alpha = (*in)[1];
  } else if (name == "omni" && (plain || distortion == "radtan")) {
    SetMei(optics, (*in)[0], focal, d);
  } else if (name == "pinhole" && (plain || distortion == "radtan")) {
    SetMei(optics, 0.0, focal, d);
  } else if (name == "pinhole" && distortion == "equidistant") {
    SetKb4(optics, focal, d);
  } else {
    return Wrong(cam, name + " with distortion_model " + distortion + ": not supported");
  }
  if (!SetSize(optics, (*size)[0], (*size)[1])) {
    return Wrong(cam, "resolution: expected whole numbers 2..65500");
  }
  return optics;
}

core::Expected<CameraChoice> BasaltOptics(const Node& camera) {
  CameraChoice optics;
  const auto type = Need(camera, "camera_type");
  const auto in = Need(camera, "intrinsics");
  if (!type) return tl::unexpected(type.error());
  if (!in) return tl::unexpected(in.error());
  const std::string& name = (*type)->text;
  std::vector<const char*> keys = {"fx", "fy", "cx", "cy"};
  if (name == "ds") {
    keys.insert(keys.end(), {"xi", "alpha"});
  } else if (name == "eucm") {
    keys.insert(keys.end(), {"alpha", "beta"});
  } else if (name == "kb4") {
    keys.insert(keys.end(), {"k1", "k2", "k3", "k4"});
  } else if (name != "pinhole") {
    return Wrong(**type,
                 "camera_type: " + (*type)->Shown() + ": expected ds, eucm, kb4 or pinhole");
  }
  Numbers n;
  for (const char* key : keys) {
    const auto number = NeedNumber(**in, key);
    if (!number) return tl::unexpected(number.error());
    n.push_back(*number);
  }
  if (name == "ds") {
    optics.camera = "double_sphere";
    SetLens(optics.double_sphere.common, optics.double_sphere.focal, n[0], n[1], n[2], n[3]);
    optics.double_sphere.xi = n[4];
    optics.double_sphere.alpha = n[5];
  } else if (name == "eucm") {
    optics.camera = "eucm";
    SetLens(optics.eucm.common, optics.eucm.focal, n[0], n[1], n[2], n[3]);
    optics.eucm.alpha = n[4];
    optics.eucm.beta = n[5];
  } else if (name == "kb4") {
    SetKb4(optics, n.data(), Numbers(n.begin() + 4, n.end()));
  } else {
    SetMei(optics, 0.0, n.data(), {});
  }
  return optics;
}

}  // namespace

Calibrations ParseKalibr(const Node& root) {
  std::vector<Calibration> all;
  Eigen::Isometry3d cam_from_body = Eigen::Isometry3d::Identity();  // of the camera before
  bool known = true;  // without an inertial unit the body is cam0
  for (int i = 0;; ++i) {
    Calibration made;
    made.name = "cam" + std::to_string(i);
    const Node* cam = root.Find(made.name);
    if (cam == nullptr) return all;
    const auto optics = KalibrOptics(*cam);
    if (!optics) return tl::unexpected(optics.error());
    made.optics = *optics;
    const Node* of_imu = cam->kind == Node::Kind::kMap ? cam->Find("T_cam_imu") : nullptr;
    const Node* of_last = cam->kind == Node::Kind::kMap ? cam->Find("T_cn_cnm1") : nullptr;
    if (of_imu != nullptr || of_last != nullptr) {
      const auto rows = NumbersOf(of_imu != nullptr ? *of_imu : *of_last, 16);
      if (!rows) return tl::unexpected(rows.error());
      const auto transform = TransformOf(*rows, of_imu != nullptr ? *of_imu : *of_last);
      if (!transform) return tl::unexpected(transform.error());
      cam_from_body = of_imu != nullptr ? *transform : *transform * cam_from_body;
      known = known || of_imu != nullptr;
    } else if (i > 0) {
      known = false;
    }
    made.has_mounting = known;
    if (known) made.body_from_optical = cam_from_body.inverse();
    if (cam->Find("timeshift_cam_imu") != nullptr) {
      const auto shift = NeedNumber(*cam, "timeshift_cam_imu");
      if (!shift) return tl::unexpected(shift.error());
      made.time_offset_s = *shift;
    }
    all.push_back(made);
  }
}

Calibrations ParseBasalt(const Node& root) {
  const auto cameras = Need(root, "intrinsics");
  const auto poses = Need(root, "T_imu_cam");
  const auto sizes = Need(root, "resolution");
  if (!cameras) return tl::unexpected(cameras.error());
  if (!poses) return tl::unexpected(poses.error());
  if (!sizes) return tl::unexpected(sizes.error());
  const std::size_t count = (*cameras)->items.size();
  if (count == 0 || (*poses)->items.size() != count || (*sizes)->items.size() != count) {
    return Wrong(root, "intrinsics, T_imu_cam and resolution: expected as many of each");
  }
  double offset_s = 0.0;
  if (root.Find("cam_time_offset_ns") != nullptr) {
    const auto offset = NeedNumber(root, "cam_time_offset_ns");
    if (!offset) return tl::unexpected(offset.error());
    offset_s = *offset * 1e-9;
  }
  std::vector<Calibration> all;
  for (std::size_t i = 0; i < count; ++i) {
    Calibration made;
    made.name = "cam" + std::to_string(i);
    const auto optics = BasaltOptics((*cameras)->items[i]);
    if (!optics) return tl::unexpected(optics.error());
    made.optics = *optics;
    const auto size = NumbersOf((*sizes)->items[i], 2);
    if (!size) return tl::unexpected(size.error());
    if (!SetSize(made.optics, (*size)[0], (*size)[1])) {
      return Wrong((*sizes)->items[i], "resolution: expected whole numbers 2..65500");
    }
    const Node& pose = (*poses)->items[i];
    Numbers n;
    for (const char* key : {"px", "py", "pz", "qx", "qy", "qz", "qw"}) {
      const auto number = NeedNumber(pose, key);
      if (!number) return tl::unexpected(number.error());
      n.push_back(*number);
    }
    const auto q = QuaternionOf(n[6], n[3], n[4], n[5]);
    if (!q) return Wrong(pose, q.error().message);
    made.body_from_optical = Eigen::Translation3d(n[0], n[1], n[2]) * *q;
    made.has_mounting = true;
    made.time_offset_s = offset_s;
    all.push_back(made);
  }
  return all;
}

Calibrations ParseOpenCv(const Node& root, OpenCvModel model) {
  const auto K =
      NeedNumbers(root, root.Find("camera_matrix") != nullptr ? "camera_matrix" : "K", 9);
  if (!K) return tl::unexpected(K.error());
  Numbers d;
  for (const char* key : {"distortion_coefficients", "D"}) {
    const Node* node = root.Find(key);
    if (node == nullptr) continue;
    const auto numbers = NumbersOf(*node, 0);
    if (!numbers) return tl::unexpected(numbers.error());
    d = *numbers;
    break;
  }
  if (model == OpenCvModel::kAuto) {
    const Node* distortion = root.Find("distortion_model");
    const Node* fisheye = root.Find("fisheye_model");
    if (root.Find("xi") != nullptr) {
      model = OpenCvModel::kOmnidir;
    } else if (distortion != nullptr) {
      const bool is_fisheye = distortion->text == "equidistant" || distortion->text == "fisheye";
      if (!is_fisheye && distortion->text != "plumb_bob") {
        return Wrong(*distortion, "distortion_model: " + distortion->Shown() +
                                      ": expected plumb_bob, equidistant or fisheye");
      }
      model = is_fisheye ? OpenCvModel::kFisheye : OpenCvModel::kPinhole;
    } else if (fisheye != nullptr) {
      model = fisheye->text == "0" ? OpenCvModel::kPinhole : OpenCvModel::kFisheye;
    } else if (d.size() == 4) {
      return Wrong(root,
                   "four distortion coefficients are a fisheye's or a pinhole's: say which by "
                   "calibration_as: opencv-fisheye or opencv-pinhole in camera.yaml");
    } else {
      model = OpenCvModel::kPinhole;
    }
  }
  const bool right_count = model == OpenCvModel::kFisheye ? d.size() == 4
                           : model == OpenCvModel::kOmnidir
                               ? d.size() == 4
                               : d.empty() || d.size() == 4 || d.size() == 5;
  if (!right_count) {
    return Wrong(root, std::to_string(d.size()) + " distortion coefficients: expected 4" +
                           (model == OpenCvModel::kPinhole ? " or 5 (k1 k2 p1 p2 k3)" : ""));
  }
  Calibration made;
  const double focal[4] = {(*K)[0], (*K)[4], (*K)[2], (*K)[5]};
  if (model == OpenCvModel::kFisheye) {
    SetKb4(made.optics, focal, d);
    made.optics.kb4.focal.skew_px = (*K)[1];
  } else {
    double xi = 0.0;
    if (model == OpenCvModel::kOmnidir) {
      const auto value = NeedNumbers(root, "xi", 1);
      if (!value) return tl::unexpected(value.error());
      xi = value->front();
    }
    SetMei(made.optics, xi, focal, d);
    made.optics.mei.focal.skew_px = (*K)[1];
  }
  if (root.Find("image_width") != nullptr) {
    const auto width = NeedNumber(root, "image_width");
    const auto height = NeedNumber(root, "image_height");
    if (!width) return tl::unexpected(width.error());
    if (!height) return tl::unexpected(height.error());
    if (!SetSize(made.optics, *width, *height)) {
      return Wrong(root, "image_width, image_height: expected whole numbers 2..65500");
    }
  }
  return std::vector{made};
}

}  // namespace kawara::survey
