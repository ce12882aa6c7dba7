#pragma once
#include "onboard/survey/calibration_file.hpp"
#include "onboard/survey/node_reading.hpp"

/// The formats of ParseCalibration, one function each.
namespace kawara::survey {

using Calibrations = core::Expected<std::vector<Calibration>>;

Calibrations ParseOcam(std::string_view text, const std::string& source);
Calibrations ParseKalibr(const Node& root);
Calibrations ParseBasalt(const Node& root);
Calibrations ParseOpenCv(const Node& root, OpenCvModel model);

/// Sets the common numbers: fx, fy, cx, cy.
inline void SetLens(vision::LensCommon& common, vision::LensFocal& focal, double fx, double fy,
                    double cx, double cy) {
  common.center_u_px = cx;
  common.center_v_px = cy;
  focal.fx_px = fx;
  focal.fy_px = fy;
}

/// Picture size, for whichever model is chosen. Empty: no such size (not whole, out of 2..65500).
bool SetSize(vision::CameraChoice& optics, double width_px, double height_px);

}  // namespace kawara::survey
