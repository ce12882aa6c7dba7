#pragma once
#include <vector>

#include "onboard/survey/pose_table.hpp"

namespace kawara::survey {

/// The pose of row `row` a little later (or earlier, below zero), by the even motion from the row
/// before it to the one after, of the same camera's rows. Rows are in any order of time; without a
/// stamp, or a neighbour within a second, the pose stays as it is.
Eigen::Isometry3d PoseLater(const std::vector<PoseRow>& rows, std::size_t row, double seconds);

}  // namespace kawara::survey
