#pragma once
#include <Eigen/Geometry>
#include <cstddef>
#include <string>

#include "core/expected.hpp"
#include "vision/change/known_place.hpp"
#include "vision/voxel/voxel_map.hpp"

namespace kawara::vision {

struct AlignOptions {
  double around_m = 12.0;       ///< of the road: surfaces farther away do not count
  double max_shift_m = 0.35;    ///< more is beyond reason: another place, or wrong poses
  double max_turn_rad = 0.026;  ///< 1.5 degrees
  double prior_sd_m = 0.15;     ///< of what RTK and the reference's survey may differ by
  double prior_turn_sd_rad = 0.006;
};

/// How the robot's map lies in the reference's.
struct Alignment {
  Eigen::Isometry3d reference_from_map = Eigen::Isometry3d::Identity();
  Eigen::Vector3d shift_m =
      Eigen::Vector3d::Zero();  ///< east, north, up, at the middle of the road
  /// Also of no shift: what could lie off unseen, the prior's where nothing stands across.
  Eigen::Vector3d shift_sd_m = Eigen::Vector3d::Zero();
  Eigen::Matrix2d plane_covariance_m2 = Eigen::Matrix2d::Zero();  ///< east, north
  double turn_rad = 0.0;                                          ///< counter-clockwise
  double residual_before_m = 0.0, residual_m = 0.0;  ///< medians of distances to its planes
  std::size_t surfaces = 0;  ///< voxels that met it; fewer than 50: nothing can be said
};

/// Shift and turn that bring surfaces that have not changed onto the reference's planes and ground:
/// least squares of distances along normals, with a redescending weight against what has changed,
/// and a weight of no shift where nothing stands across; it begins where SearchShift finds that
/// upright surfaces speak for a far one. Another shift that does not lessen the residuals is none.
/// Errors: kInvalidArgument, with the shift, if it is beyond reason.
core::Expected<Alignment> AlignReference(const VoxelMap& map, const KnownPlace& place,
                                         const OccupancyRule& rule, const AlignOptions& options);

/// For people: the direction in the plane in which too little stands for a shift to be seen, and
/// what is allowed for; empty: there is none.
std::string Unchecked(const Alignment& alignment);

}  // namespace kawara::vision
