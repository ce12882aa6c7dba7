#pragma once
#include <string>

#include "vision/calibration/calibrator.hpp"

namespace kawara::calibrate {

/// camera.yaml of a survey folder (docs/survey_format.md): the model and its numbers, deviations
/// and residuals beside them as comments. `origin`: what it was made from, for people; one line.
std::string CameraFileOf(const vision::CameraCalibration& made, const std::string& origin);

}  // namespace kawara::calibrate
