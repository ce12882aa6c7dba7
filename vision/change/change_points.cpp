#include "vision/change/change_points.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::vision {

std::int64_t ChangePoints::GroundKey(const Eigen::Vector2d& p) {
  const auto index = [](double v) {
    return static_cast<std::int64_t>(std::floor(v / kGroundCell));
  };
  return index(p.x()) * (std::int64_t{1} << 32) + index(p.y());
}

namespace {

/// Metres that the robot's map may lie off the reference's, and a turn moves its ends.
constexpr double kMostOff = 2.0;

ChangePoint PointOf(const OccupiedVoxel& occupied, double voxel_m) {
  const Voxel& v = occupied.voxel;
  ChangePoint point;
  point.voxel = occupied.index;
  point.position_m = CentroidVoxels(occupied.index, v) * voxel_m;
  point.weight = static_cast<double>(v.weight);
  point.hits = v.hits;
  point.vote_sd_m = std::sqrt(static_cast<double>(v.hits) / std::max(1e-9, point.weight));
  point.hit_share = static_cast<double>(v.hits) / (static_cast<double>(v.hits) + v.see_through);
  const Eigen::Vector3d look(v.to_viewer[0], v.to_viewer[1], v.to_viewer[2]);
  if (look.norm() > 0.1 * Voxel::kViewOne) {
    point.to_viewer = look.normalized();
    point.view_spread = std::max(0.0, 1.0 - look.norm() / Voxel::kViewOne);
  }
  return point;
}

}  // namespace

ChangePoints FindChangePoints(const VoxelMap& map, const KnownPlace& place,
                              const Eigen::Isometry3d& reference_from_map,
                              const ChangeOptions& options,
                              const std::optional<PlaneDisc>& within) {
  ChangePoints result;
  const double voxel_m = map.config().voxel_m;
  const auto index = [&](double m) { return static_cast<std::int32_t>(std::floor(m / voxel_m)); };
  // The road lies in the reference's frame, as its ground and surfaces do.
  const double around_m = options.margin_m + kMostOff;
  Eigen::Vector2d low = place.road.min_m() - Eigen::Vector2d::Constant(around_m);
  Eigen::Vector2d high = place.road.max_m() + Eigen::Vector2d::Constant(around_m + voxel_m);
  if (within) {
    const Eigen::Vector2d reach = Eigen::Vector2d::Constant(within->radius_m);
    low = low.cwiseMax(within->centre_m - reach);
    high = high.cwiseMin(within->centre_m + reach + Eigen::Vector2d::Constant(voxel_m));
  }
  constexpr std::int32_t kAnyHeight = 1 << 22;
  map.ForEachOccupied(
      {index(low.x()), index(low.y()), -kAnyHeight}, {index(high.x()), index(high.y()), kAnyHeight},
      options.rule, [&](const OccupiedVoxel& occupied) {
        ChangePoint point = PointOf(occupied, voxel_m);
        const Eigen::Vector2d plane = point.position_m.head<2>();
        if (within && !within->Contains(plane)) return;
        const Eigen::Vector3d in_reference = reference_from_map * point.position_m;
        if (place.road.SignedDistance(in_reference.head<2>()) < -options.margin_m) return;
        const auto up = place.reference.ground.At(in_reference.head<2>());
        if (!up) {
          ++result.no_ground;
          return;
        }
        point.height_m = in_reference.z() - up->up_m;
        if (point.height_m < options.min_height_m) {
          if (point.height_m > -options.min_height_m)
            result.ground_seen.insert(ChangePoints::GroundKey(plane));
          return;
        }
        if (point.height_m > options.max_height_m) return;
        ++result.surface;
        const auto match = place.reference.Nearest(in_reference, options.max_tolerance_m);
        if (match) {
          const double sd =
              std::sqrt(match->sd_m * match->sd_m + point.vote_sd_m * point.vote_sd_m +
                        options.pose_sd_m * options.pose_sd_m);
          if (match->distance_m <= std::min(options.max_tolerance_m, options.sigmas * sd)) {
            ++result.explained;
            return;
          }
        }
        if (point.view_spread < options.min_view_spread) {
          ++result.one_view;
          return;
        }
        result.points.push_back(point);
      });
  return result;
}

}  // namespace kawara::vision
