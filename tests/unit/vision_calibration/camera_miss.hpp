#pragma once
#include <gtest/gtest.h>

#include <cmath>

#include "vision/calibration/coverage.hpp"
#include "vision/camera/camera_model.hpp"

namespace kawara::vision {

/// How far from where they belong a camera projects the rays of the pixels that boards reached:
/// root of the mean square distance [px].
inline double MissPx(const CameraModel& truth, const CameraModel& made, const Coverage& covered) {
  double sum = 0.0;
  int rays = 0;
  for (int v = 5; v < truth.height_px(); v += 15) {
    for (int u = 5; u < truth.width_px(); u += 15) {
      const Eigen::Vector2d pixel(u, v);
      const double radius = (pixel - truth.Symmetry()->center_px).norm();
      if (radius < covered.low_px || radius > covered.high_px) continue;
      const auto ray = truth.Unproject(pixel);
      if (!ray) continue;
      const auto again = made.Project(*ray);
      EXPECT_TRUE(again) << pixel.transpose();
      if (!again) continue;
      sum += (*again - pixel).squaredNorm();
      ++rays;
    }
  }
  EXPECT_GT(rays, 500);
  return std::sqrt(sum / rays);
}

}  // namespace kawara::vision
