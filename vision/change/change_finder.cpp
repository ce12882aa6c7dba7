#include "vision/change/change_finder.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::vision {
namespace {

/// That a region is a thing: every few voxels are one witness, who is right as often as rays ended
/// at them and did not go on through.
double ExistenceProbability(const ChangeRegion& region, const BoxOptions& options) {
  constexpr double kPriorLogOdds = -2.0, kMostShare = 0.9;
  double log_odds = kPriorLogOdds;
  for (const ChangePoint& p : region.points) {
    const double share = std::clamp(p.hit_share, 1.0 - kMostShare, kMostShare);
    log_odds += std::log(share / (1.0 - share)) / options.correlated_voxels;
  }
  return 1.0 / (1.0 + std::exp(-std::clamp(log_odds, -30.0, 30.0)));
}

core::ChangedObject ObjectOf(const ChangeRegion& region, const FittedBox& fitted,
                             const BoxOptions& options) {
  core::ChangedObject object;
  object.box = fitted.box;
  object.covariance = fitted.covariance;
  object.side_seen = fitted.side_seen;
  object.second_heading_rad = fitted.second_heading_rad;
  object.size_class = fitted.size.cls;
  object.class_probability = fitted.size.probability;
  object.existence_probability = ExistenceProbability(region, options);
  object.voxels = static_cast<std::uint32_t>(region.points.size());
  for (const ChangePoint& p : region.points) object.votes += p.hits;
  return object;
}

/// Of a side across a dimension (row of the covariance): half of size and centre each hold a part.
double SideDeviation(const core::ChangedObject& object, int row) {
  return std::clamp(std::sqrt(std::max(0.0, object.covariance(row, row))) / 2.0, 0.02, 0.5);
}

}  // namespace

FinderOptions PaperFinder() {
  constexpr double kAnyDeviation = 1e3;
  FinderOptions options;
  options.method = ChangeMethod::kPaper;
  options.change.sigmas = kAnyDeviation;
  options.change.min_view_spread = 0.0;
  options.change.rule = {.min_hits = 20, .min_weight = 0.0, .min_hit_share = 0.0};
  options.region.min_skirt_share = 0.0;
  options.region.min_hidden_m2 = 0.0;
  return options;
}

Findings FindChanges(const VoxelMap& map, const KnownPlace& place,
                     const Eigen::Isometry3d& reference_from_map, const FinderOptions& options,
                     const std::optional<PlaneDisc>& within) {
  const RoadArea& road = place.road;
  Findings findings;
  findings.within = within;
  findings.look = FindChangePoints(map, place, reference_from_map, options.change, within);
  const double voxel_m = map.config().voxel_m;
  const double margin_m = options.change.margin_m;
  const auto cut_m = [&](const Eigen::Vector2d& p) { return road.SignedDistance(p) + margin_m; };
  for (ChangeRegion& region : LabelRegions(findings.look, voxel_m, options.region)) {
    double up_m = 0.0;
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (const ChangePoint& p : region.points) {
      up_m += p.position_m.z() - p.height_m;
      middle += p.position_m.head<2>();
    }
    up_m /= static_cast<double>(region.points.size());
    middle /= static_cast<double>(region.points.size());
    BoxOptions box = options.box;
    box.voxel_m = voxel_m;
    box.road_heading_rad = RoadHeadingAt(place.axes, middle);
    const FittedBox fitted = options.method == ChangeMethod::kPaper
                                 ? FitBoxPaper(region, up_m, box.road_heading_rad.value_or(0.0))
                                 : FitBox(region, up_m, cut_m, box);
    findings.changes.push_back({ObjectOf(region, fitted, box), std::move(region)});
  }
  // Where the road lies, the robot's map may lie a little off: the width is the reference's.
  std::vector<Obstacle> obstacles;
  for (const FoundChange& change : findings.changes) {
    Obstacle obstacle{change.object.box, SideDeviation(change.object, 4),
                      SideDeviation(change.object, 3)};
    const Eigen::Matrix3d R = reference_from_map.linear();
    obstacle.box.centre_m = reference_from_map * obstacle.box.centre_m;
    obstacle.box.heading_rad -= std::atan2(R(1, 0), R(0, 0));
    obstacles.push_back(obstacle);
  }
  for (const RoadAxis& axis : place.axes) {
    auto stations = MeasureWidth(road, axis, obstacles, findings.look, options.width, within);
    for (core::RoadStation& station : stations) {
      for (Eigen::Vector3d* edge : {&station.left_m, &station.right_m})
        if (const auto up = place.reference.ground.At(edge->head<2>())) edge->z() = up->up_m;
      findings.stations.push_back(std::move(station));
    }
  }
  return findings;
}

}  // namespace kawara::vision
