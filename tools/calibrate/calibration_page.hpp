#pragma once
#include <string>

#include "tools/calibrate/board_pictures.hpp"
#include "vision/calibration/calibrator.hpp"

namespace kawara::calibrate {

/// The calibration for people, an HTML page that needs nothing else: the numbers with deviations,
/// residuals as arrows over the picture, their histogram, over the radius and a picture each, and
/// where boards were. `pictures`: those `made` was made from.
std::string CalibrationPage(const vision::CameraCalibration& made, const BoardPictures& pictures,
                            const std::string& origin);

}  // namespace kawara::calibrate
