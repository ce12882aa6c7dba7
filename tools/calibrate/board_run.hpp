#pragma once
#include <functional>
#include <optional>
#include <string>

#include "core/expected.hpp"
#include "vision/calibration/calibrator.hpp"

namespace kawara::calibrate {

struct BoardOptions {
  std::string folder;
  std::string board = "9x6";  ///< inner corners
  double square_m = 0.0;
  std::string model = "auto";  ///< a CalibrationModel's name, or auto
  std::string axis;            ///< forward, up, down; empty: up for a doughnut, else forward
  bool mirrored = false;
  std::optional<double> inner_px, outer_px;
  std::string out;
  std::string report;  ///< empty: none
};

struct BoardResult {
  vision::CameraCalibration camera;
  int pictures = 0;
  std::size_t views = 0, corners = 0;
};

/// Pictures in, camera.yaml and the report out. `say` gets warnings as they come, a line each.
/// Errors, one line: kInvalidArgument and kNotFound are the caller's, others the pictures'.
core::Expected<BoardResult> RunBoard(const BoardOptions& options,
                                     const std::function<void(const std::string&)>& say);

}  // namespace kawara::calibrate
