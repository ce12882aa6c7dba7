#pragma once
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_set>
#include <vector>

#include "vision/change/known_place.hpp"
#include "vision/voxel/voxel_map.hpp"

namespace kawara::vision {

struct ChangeOptions {
  /// Above the ground: what is lower can be driven over, what is higher hangs over the road.
  double min_height_m = 0.30;
  double max_height_m = 4.5;
  /// Things are looked for this far beyond the road's edge.
  double margin_m = 0.3;
  /// Known to 3.5 cm.
  OccupancyRule rule{.min_hits = 6, .min_weight = 800.0, .min_hit_share = 0.5};
  /// Seen from places as far apart as 1 - mean cosine says (0.0006: 2 degrees rms): one picture's
  /// blunder is seen from one. For clouds of one standpoint: 0.
  double min_view_spread = 0.0006;
  /// A surface within so many deviations of the reference is the reference.
  double sigmas = 3.0;
  double pose_sd_m = 0.03;  ///< of the robot in the reference's frame, if nothing better is known
  double max_tolerance_m = 0.5;  ///< however poor the reference: the paper's voxel
};

/// A surface voxel that the reference does not explain.
struct ChangePoint {
  VoxelIndex voxel;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< mean of its votes, map
  double height_m = 0.0;                                 ///< above the ground
  double vote_sd_m = 0.0;                                ///< typical deviation of one vote
  double weight = 0.0;                                   ///< sum of 1 / variance [1/m^2]
  double hit_share = 1.0;                                ///< of votes and rays that went through
  std::uint32_t hits = 0;
  Eigen::Vector3d to_viewer = Eigen::Vector3d::Zero();  ///< unit, or zero: not known
  /// 1 - length of the mean of the unit vectors to the viewers: 0 if one picture said it all.
  double view_spread = 0.0;
};

/// What a look at the road gave.
struct ChangePoints {
  std::vector<ChangePoint> points;  ///< in order of their voxels' blocks
  /// Cells of the road whose ground was seen, of kGroundCell: nothing stands there.
  static constexpr double kGroundCell = 0.25;
  std::unordered_set<std::int64_t> ground_seen;
  std::uint64_t surface = 0;    ///< voxels of surfaces above the road
  std::uint64_t explained = 0;  ///< of them by the reference
  std::uint64_t one_view = 0;   ///< and seen from one place only
  std::uint64_t no_ground = 0;  ///< voxels on the road where the ground's height is not known

  static std::int64_t GroundKey(const Eigen::Vector2d& p);
  bool GroundSeen(const Eigen::Vector2d& p) const { return ground_seen.contains(GroundKey(p)); }
};

/// Surfaces that the reference, its ground and its road do not explain (the paper's section 5 B 2,
/// with tolerances from deviations in place of a fixed voxel). The reference may hold no surfaces:
/// then everything that stands on the road is a change. `reference_from_map`: where the robot's map
/// lies in the reference's (AlignReference). Only voxels in memory count, and those `within` if
/// that is given.
ChangePoints FindChangePoints(const VoxelMap& map, const KnownPlace& place,
                              const Eigen::Isometry3d& reference_from_map,
                              const ChangeOptions& options,
                              const std::optional<PlaneDisc>& within = {});

/// Heights of the ground on the road from the robot's own voxels, for references that have none:
/// the lowest surfaces that a smooth ground can join.
GroundField EstimateGround(const VoxelMap& map, const RoadArea& road, const OccupancyRule& rule,
                           double margin_m);

}  // namespace kawara::vision
