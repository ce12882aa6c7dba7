#pragma once
#include <cstddef>

namespace kawara::vision::range {

/// A disparity field and how its rays run, for reading it at the rays of A's pixels.
struct FieldView {
  const float* disparity_px;  ///< [height][width], below zero unknown
  const float* sd_px;
  int width = 0, height = 0;
  float px_per_rad = 0.0F;
  float first_alpha_rad = 0.0F;
  float baseline_m = 0.0F;
  float turn_sd_rad = 0.0F;            ///< of StepDoubt
  float length_relative_sd = 0.0F;     ///< of StepDoubt
  float epipolar_from_camera[9] = {};  ///< row by row
};

/// Ranges of unit rays (camera frame, NaN: not seen) and their deviations; NaN where unknown.
/// Arrays may be read and written to the next multiple of 16.
void RangesOfRow(const FieldView& field, const float* x, const float* y, const float* z,
                 std::size_t count, float* range_m, float* sd_m);

}  // namespace kawara::vision::range
