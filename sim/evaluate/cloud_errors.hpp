#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/expected.hpp"
#include "sim/evaluate/error_statistics.hpp"

namespace kawara::sim {

/// A model (points on its surfaces, or centres of its voxels) against the true surfaces as points:
/// accuracy is how far the result lies from the truth, completeness how far the truth from the
/// result; precision and recall are the shares nearer than 5, 10, 20 and 50 cm, F their harmonic
/// mean (Knapitsch et al., Tanks and Temples, 2017); and of the voxels of `voxel_m` that either
/// touches, the shares that are right, found and shared. Both clouds in the same axes.
/// kInvalidArgument: a cloud is empty.
core::Expected<ErrorReport> CompareClouds(const std::vector<Eigen::Vector3d>& truth,
                                          const std::vector<Eigen::Vector3d>& result,
                                          double voxel_m);

}  // namespace kawara::sim
