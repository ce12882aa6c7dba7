#pragma once
#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>

#include "core/changed_object.hpp"
#include "vision/change/change_regions.hpp"
#include "vision/change/size_prior.hpp"

namespace kawara::vision {

struct BoxOptions {
  double voxel_m = 0.20;
  /// What all points of a pass may be off by together: never averaged away.
  double pose_sd_m = 0.03;
  double pose_heading_sd_rad = 0.002;
  /// True heading of the road there, clockwise from north [rad]: things are parked along it or
  /// across, mostly. Nothing: no such weight.
  std::optional<double> road_heading_rad;
  double road_heading_sd_rad = 0.10;
  /// Votes of neighbouring pixels err together: of so many voxels one counts.
  double correlated_voxels = 6.0;
};

/// A box fitted to a region, and how well.
struct FittedBox {
  core::UprightBox box;
  Eigen::Matrix<double, 7, 7> covariance = Eigen::Matrix<double, 7, 7>::Zero();
  std::array<bool, core::kBoxSides> side_seen{};
  std::optional<double> second_heading_rad;
  SizeGuess size;
};

/// Smallest upright box that explains a region: the heading whose sides gather the points best (an
/// L-shape search as Zhang, Xu, Dong and Dolan, IV 2017, with a likelihood of points on sides in
/// place of closeness), sides at the peaks of the votes' density, hidden sides where things of that
/// size have theirs. `ground_m`: height of the ground in the map under a place in the plane.
/// `cut_m`: how far a point lies within the area that was searched (RoadArea::SignedDistance plus
/// its margin): what ends at the area's edge was cut there, not seen to end.
FittedBox FitBox(const ChangeRegion& region, double ground_m,
                 const std::function<double(const Eigen::Vector2d&)>& cut_m,
                 const BoxOptions& options);

/// The paper's box (section 5 B 2, fig. 15): projections on the planes X-Y and Y-Z, axes parallel
/// to the map's (`along_road`: to the road's), all sides at the outermost points.
FittedBox FitBoxPaper(const ChangeRegion& region, double ground_m, double heading_rad);

}  // namespace kawara::vision
