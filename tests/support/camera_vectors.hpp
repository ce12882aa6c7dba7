#pragma once
#include <Eigen/Core>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "vision/camera/camera_choice.hpp"

namespace kawara::vision {

/// One model of data/camera/model_vectors.txt (its README explains the numbers).
struct CameraVectors {
  std::string set;    ///< the calibration set
  std::string model;  ///< KB4, OCam-poly4, ...
  std::vector<double> parameters;
  std::vector<Eigen::Vector3d> rays_optical;
  std::vector<Eigen::Vector2d> pixels;
};

inline std::vector<CameraVectors> ReadCameraVectors() {
  std::ifstream file(std::string(KAWARA_SOURCE_DIR) + "/data/camera/model_vectors.txt");
  std::vector<CameraVectors> all;
  std::string word, line;
  int count = 0;
  file >> word >> count;
  std::vector<Eigen::Vector3d> rays(static_cast<std::size_t>(count));
  for (auto& ray : rays) file >> ray.x() >> ray.y() >> ray.z();
  while (file >> word) {
    CameraVectors v;
    v.rays_optical = rays;
    std::getline(file, line);
    std::istringstream fields(line);
    fields >> word;
    v.set = word.substr(0, word.find('/'));
    v.model = word.substr(word.find('/') + 1);
    for (double value = 0; fields >> value;) v.parameters.push_back(value);
    v.pixels.resize(rays.size());
    for (auto& pixel : v.pixels) file >> pixel.x() >> pixel.y();
    all.push_back(v);
  }
  return all;
}

/// The camera these numbers mean. Not for eq2-linear, which is a doughnut.
inline CameraChoice ChoiceOf(const CameraVectors& vectors) {
  const std::vector<double>& p = vectors.parameters;
  LensCommon common;
  common.width_px = 1280;
  common.height_px = 1024;
  common.center_u_px = p[0];
  common.center_v_px = p[1];
  const LensFocal focal{p[3], p[2] * p[3], 0.0};
  CameraChoice c;
  if (vectors.model == "equidistant") {
    c.camera = "equidistant";
    c.equidistant = {common, focal, {}};
  } else if (vectors.model == "KB4") {
    c.camera = "kb4";
    c.kb4 = {common, focal, {p[4], p[5], p[6], p[7]}};
  } else if (vectors.model == "OCam-poly4") {
    c.camera = "ocam";
    c.ocam = {common, {-p[3], 0.0, -p[4] * 1e-3, -p[5] * 1e-6, -p[6] * 1e-9}, p[2], 0.0, 0.0};
  } else if (vectors.model == "UCM" || vectors.model == "UCM+k1k2") {
    c.camera = "mei";
    c.mei = {common, focal, p[4]};
    if (p.size() > 5) {
      c.mei.k1 = p[5];
      c.mei.k2 = p[6];
    }
  } else if (vectors.model == "EUCM") {
    c.camera = "eucm";
    c.eucm = {common, focal, p[4], p[5]};
  } else if (vectors.model == "DS") {
    c.camera = "double_sphere";
    c.double_sphere = {common, focal, p[4], p[5]};
  }
  return c;
}

}  // namespace kawara::vision
