#pragma once
#include <ostream>
#include <string>
#include <vector>

#include "core/geodesy.hpp"
#include "vision/calibration/trial_camera.hpp"

/// Cameras whose numbers are to be found again: one of every model.
namespace kawara::vision {

struct KnownCamera {
  CalibrationModel model;
  CameraChoice choice;
  OpticalAxis axis = OpticalAxis::kForward;
  bool mirrored = false;
  double low_rad, high_rad;  ///< angles from the axis at which boards' middles are held
};

inline void PrintTo(const KnownCamera& known, std::ostream* os) { *os << NameOf(known.model); }

constexpr int kSidePx = 800;

inline LensCommon KnownCommon(double max_angle_deg) {
  LensCommon common;
  common.width_px = common.height_px = kSidePx;
  common.center_u_px = 404.3;
  common.center_v_px = 396.1;
  common.max_angle_deg = max_angle_deg;
  return common;
}

inline std::vector<KnownCamera> KnownCameras() {
  const auto deg = [](double degrees) { return degrees * core::kRadFromDeg; };
  std::vector<KnownCamera> all;
  {
    DoughnutParameters ring;  // a mirror seen from below: the outer circle looks up
    ring.width_px = ring.height_px = kSidePx;
    ring.center_u_px = 402.7;
    ring.center_v_px = 397.4;
    ring.l_in_px = 90.0;
    ring.l_out_px = 390.0;
    ring.phi_top_deg = 50.0;
    ring.phi_bottom_deg = -40.0;
    ring.l_base_px = 90.0 + 300.0 * 50.0 / 90.0;
    all.push_back({CalibrationModel::kDoughnut, CameraChoice::Of(ring), OpticalAxis::kUp, false,
                   deg(55), deg(115)});
    DoughnutParameters mirror = ring;
    mirror.mirrored = true;
    mirror.v_scale = 1.01;
    mirror.correction = {0.05, -0.01, 0.0, 0.0};
    // Linear in P(a) between the circles at 40 and 130 deg from the axis.
    const OddPolynomial unit{mirror.correction};
    const double inner = unit.Value(deg(40)), outer = unit.Value(deg(130));
    mirror.l_base_px = 90.0 + 300.0 * (unit.Value(core::kPi / 2) - inner) / (outer - inner);
    all.push_back({CalibrationModel::kDoughnutCorrected, CameraChoice::Of(mirror), OpticalAxis::kUp,
                   true, deg(55), deg(115)});
  }
  {
    CameraChoice c;
    c.camera = "ocam";
    c.ocam.common = KnownCommon(105);
    // Of r = f theta with f = 215: r cot(r / f) = f - r^2 / 3f - r^4 / 45 f^3.
    c.ocam.polynomial = {215.0, 0.0, -1.0 / 645.0, 1e-8, -1.0 / (45.0 * 215.0 * 215.0 * 215.0)};
    c.ocam.affine_c = 1.002;
    c.ocam.affine_d = 0.0005;
    all.push_back({CalibrationModel::kOcam, c, OpticalAxis::kForward, false, deg(5), deg(85)});
  }
  {
    CameraChoice c;
    c.camera = "mei";
    c.mei.common = KnownCommon(100);
    c.mei.focal = {.fx_px = 420.0, .fy_px = 421.0};
    c.mei.xi = 1.15;
    c.mei.k1 = -0.02;
    c.mei.k2 = 0.004;
    all.push_back({CalibrationModel::kMei, c, OpticalAxis::kForward, false, deg(5), deg(80)});
  }
  {
    CameraChoice c;
    c.camera = "double_sphere";
    c.double_sphere.common = KnownCommon(100);
    c.double_sphere.focal = {.fx_px = 190.0, .fy_px = 190.5};
    c.double_sphere.xi = -0.18;
    c.double_sphere.alpha = 0.6;
    all.push_back(
        {CalibrationModel::kDoubleSphere, c, OpticalAxis::kForward, false, deg(5), deg(80)});
  }
  {
    CameraChoice c;
    c.camera = "eucm";
    c.eucm.common = KnownCommon(100);
    c.eucm.focal = {.fx_px = 240.0, .fy_px = 240.4};
    c.eucm.alpha = 0.62;
    c.eucm.beta = 1.1;
    all.push_back({CalibrationModel::kEucm, c, OpticalAxis::kForward, false, deg(5), deg(80)});
  }
  {
    CameraChoice c;
    c.camera = "kb4";
    c.kb4.common = KnownCommon(100);
    c.kb4.focal = {.fx_px = 225.0, .fy_px = 225.3};
    c.kb4.k = {-0.012, 0.004, -0.002, 0.0003};
    all.push_back(
        {CalibrationModel::kKannalaBrandt, c, OpticalAxis::kForward, false, deg(5), deg(80)});
  }
  return all;
}

}  // namespace kawara::vision
