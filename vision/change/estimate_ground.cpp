#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "vision/change/change_points.hpp"

namespace kawara::vision {
namespace {

constexpr double kCell = 0.5;        // m
constexpr double kSlope = 0.15;      // a road's
constexpr double kRoughness = 0.08;  // m
constexpr std::int32_t kReach = 12;  // cells that a surface's foot may be away

}  // namespace

GroundField EstimateGround(const VoxelMap& map, const RoadArea& road, const OccupancyRule& rule,
                           double margin_m) {
  GroundField ground(kCell);
  const double voxel_m = map.config().voxel_m;
  // Of each cell the heights of its voxels, the heaviest votes near the bottom.
  std::map<GroundField::Cell, std::vector<std::pair<double, double>>> columns;
  map.ForEachOccupied(rule, [&](const OccupiedVoxel& occupied) {
    const Eigen::Vector3d p = CentroidVoxels(occupied.index, occupied.voxel) * voxel_m;
    if (road.SignedDistance(p.head<2>()) < -margin_m) return;
    columns[ground.CellOf(p.head<2>())].emplace_back(p.z(),
                                                     static_cast<double>(occupied.voxel.weight));
  });
  std::map<GroundField::Cell, double> lowest;
  for (auto& [cell, heights] : columns) {
    std::sort(heights.begin(), heights.end());
    double all = 0.0;
    for (const auto& [up, weight] : heights) all += weight;
    // Stray votes lie below the ground too: the lowest that a twentieth of the weight lies under.
    double below = 0.0;
    for (const auto& [up, weight] : heights) {
      below += weight;
      if (below >= 0.05 * all) {
        lowest[cell] = up;
        break;
      }
    }
  }
  // The ground is no higher than its neighbours allow: what stands on it is left out.
  for (const auto& [cell, up_m] : lowest) {
    double sum = 0.0, weight = 0.0;
    bool stands = false;
    for (std::int32_t dy = -kReach; dy <= kReach && !stands; ++dy)
      for (std::int32_t dx = -kReach; dx <= kReach; ++dx) {
        const auto other = lowest.find({cell.first + dx, cell.second + dy});
        if (other == lowest.end()) continue;
        const double away_m = kCell * std::hypot(dx, dy);
        if (other->second < up_m - kRoughness - kSlope * away_m) {
          stands = true;
          break;
        }
        if (away_m <= 2.0 * kCell) {
          sum += other->second;
          weight += 1.0;
        }
      }
    if (!stands) ground.Set(cell, {std::min(up_m + kRoughness, sum / weight), kRoughness / 2});
  }
  // Under what stands: the level of what lies around, by the inverse square of its distance.
  GroundField filled = ground;
  for (const auto& [cell, up_m] : lowest) {
    const Eigen::Vector2d centre((cell.first + 0.5) * kCell, (cell.second + 0.5) * kCell);
    double sum = 0.0, weight = 0.0;
    for (std::int32_t dy = -kReach; dy <= kReach; ++dy)
      for (std::int32_t dx = -kReach; dx <= kReach; ++dx) {
        const auto* const known = ground.Find({cell.first + dx, cell.second + dy});
        if (known == nullptr) continue;
        const double w = 1.0 / (0.25 + dx * dx + dy * dy);
        sum += w * known->up_m;
        weight += w;
      }
    if (ground.Find(cell) == nullptr && weight > 0.0)
      filled.Set(cell, {sum / weight, 2.0 * kRoughness});
  }
  return filled;
}

}  // namespace kawara::vision
