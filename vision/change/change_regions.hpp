#pragma once
#include <vector>

#include "vision/change/change_points.hpp"

namespace kawara::vision {

struct RegionOptions {
  /// Columns of voxels belong together when their means are nearer than this in the plane.
  double link_m = 0.40;
  double column_m = 0.20;
  /// Less surface than this is noise, not a thing [m^2].
  double min_surface_m2 = 0.4;
  /// What begins higher than this above the ground hangs over the road: wires, branches, signs.
  double overhead_m = 2.0;
  /// Voxels there must be within one of a voxel (two up and down), itself counted: the paper's
  /// "remove isolated points".
  int company = 3;
  /// A voxel of less than this share of the weight of the heaviest within two voxels is the skirt
  /// that noise puts around a surface.
  double min_skirt_share = 0.03;
  /// A thing smaller than this must stand where the ground beside it was seen: blunders gather in
  /// the shadow of things, where nobody can look through them [m^2].
  double min_hidden_m2 = 1.2;
  double min_ground_share = 0.25;  ///< of the squares around its foot
};

/// Changed surface voxels that belong together (the paper's labelling, section 5 B 2).
struct ChangeRegion {
  std::vector<ChangePoint> points;
};

/// Points to regions, isolated ones left out. Largest first; ties by place. Deterministic.
std::vector<ChangeRegion> LabelRegions(const ChangePoints& look, double voxel_m,
                                       const RegionOptions& options);

}  // namespace kawara::vision
