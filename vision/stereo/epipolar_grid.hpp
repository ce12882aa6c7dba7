#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/geodesy.hpp"

namespace kawara::vision {

/// Pixels of the epipolar sphere: rows are meridians all around, columns the angle from the pole,
/// without the two caps about the poles in which stereo sees nothing. Both axes have the same step.
struct EpipolarGrid {
  int width_px = 0;   ///< a multiple of 32
  int height_px = 0;  ///< a multiple of 8
  double px_per_rad = 0.0;
  double first_alpha_rad = 0.0;  ///< of column 0's centre

  /// About `px_per_rad`, such that the rows close the circle. `cap_rad`: half opening of the caps.
  static EpipolarGrid Make(double px_per_rad, double cap_rad) {
    EpipolarGrid grid;
    grid.height_px = std::max(16, 8 * static_cast<int>(std::lround(core::kPi * px_per_rad / 4.0)));
    grid.px_per_rad = grid.height_px / (2.0 * core::kPi);
    grid.width_px =
        std::max(64, static_cast<int>((core::kPi - 2.0 * cap_rad) * grid.px_per_rad) / 32 * 32);
    grid.first_alpha_rad = core::kPi / 2.0 - 0.5 * (grid.width_px - 1) / grid.px_per_rad;
    return grid;
  }

  /// Of pixels twice as wide and high; sizes must be multiples of 32 and 4.
  EpipolarGrid Halved() const {
    EpipolarGrid half = *this;
    half.width_px = width_px / 2;
    half.height_px = height_px / 2;
    half.px_per_rad = px_per_rad / 2.0;
    half.first_alpha_rad = first_alpha_rad + 0.5 / px_per_rad;
    return half;
  }

  double alpha_rad(double x_px) const { return first_alpha_rad + x_px / px_per_rad; }
  double beta_rad(double y_px) const { return (y_px + 0.5) / px_per_rad; }
  double x_px(double alpha_rad) const { return (alpha_rad - first_alpha_rad) * px_per_rad; }
  /// beta in [0, 2 pi) gives [-0.5, height - 0.5).
  double y_px(double beta_rad) const { return beta_rad * px_per_rad - 0.5; }
  std::size_t pixels() const {
    return static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  }
};

}  // namespace kawara::vision
