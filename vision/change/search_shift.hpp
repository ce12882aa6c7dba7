#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "vision/change/reference_map.hpp"

namespace kawara::vision {

struct ShiftSearchOptions {
  double reach_m = 1.0;  ///< east and north: of the square that is searched
  double step_m = 0.1;
  double scale_m = 0.12;  ///< rms of a surface about its plane, poses and voxels included
  /// What lies on a plane is so much likelier there than anywhere.
  double odds = 6.0;
};

/// What speaks for a shift, and for none: log likelihoods of upright surfaces [nats], as if every
/// voxel were independent.
struct ShiftFound {
  Eigen::Vector2d shift_m = Eigen::Vector2d::Zero();  ///< east, north: to add to the points
  double nats = 0.0;
  double nats_without = 0.0;
  std::size_t surfaces = 0;  ///< points within reach of an upright of the reference
};

/// The whole square of plane shifts is tried, as a descent finds the nearest valley only and a pole
/// of 50 cm voxels is lost at half a metre. Uprights alone are asked: ground says nothing of a
/// plane shift, and there is a hundred times more of it. Points that meet nothing anywhere, as what
/// has changed does, speak for no shift. Pure.
ShiftFound SearchShift(const std::vector<Eigen::Vector3d>& points, const ReferenceMap& reference,
                       const ShiftSearchOptions& options);

}  // namespace kawara::vision
