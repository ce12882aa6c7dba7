#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "vision/calibration/coverage.hpp"

namespace kawara::calibrate {

/// A corner as it was seen, and how far that is from where the camera puts it.
struct Residual {
  Eigen::Vector2d pixel_px, miss_px;
  bool used = true;
};

// Drawings as inline SVG elements.

/// Arrows over the picture, drawn out to be seen; corners left out are red. With cells that hold no
/// corner shaded.
std::string ResidualArrowsSvg(const std::vector<Residual>& residuals, int width_px, int height_px,
                              const Eigen::Vector2d& center_px, const vision::Coverage& coverage);
/// Both coordinates of the corners used.
std::string ResidualHistogramSvg(const std::vector<Residual>& residuals);
/// Sizes over the distance from the centre, with the root mean square of every ring.
std::string ResidualRadiusSvg(const std::vector<Residual>& residuals,
                              const Eigen::Vector2d& center_px);

}  // namespace kawara::calibrate
