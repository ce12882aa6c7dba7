#include "vision/change/change_regions.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <unordered_map>

namespace kawara::vision {
namespace {

/// Everything above one square of the plane.
struct Column {
  std::vector<std::size_t> points;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double weight = 0.0;
};

using Square = std::pair<std::int32_t, std::int32_t>;

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n) : parent_(n) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  std::size_t Find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void Join(std::size_t a, std::size_t b) {
    parent_[std::max(Find(a), Find(b))] = std::min(Find(a), Find(b));
  }

 private:
  std::vector<std::size_t> parent_;
};

std::int64_t KeyOf(const VoxelIndex& v) {
  constexpr std::int64_t kMask = (std::int64_t{1} << 21) - 1;
  return ((v.x & kMask) << 42) | ((v.y & kMask) << 21) | (v.z & kMask);
}

/// The paper's "remove isolated points": a voxel needs others next to it. Skirts of noise go too.
std::vector<std::size_t> Accompanied(const std::vector<ChangePoint>& points,
                                     const RegionOptions& options) {
  std::unordered_map<std::int64_t, double> there;
  for (const ChangePoint& p : points) there[KeyOf(p.voxel)] = p.weight;
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const VoxelIndex& v = points[i].voxel;
    int near = 0;
    double heaviest = 0.0;
    for (std::int32_t dz = -2; dz <= 2; ++dz)
      for (std::int32_t dy = -2; dy <= 2; ++dy)
        for (std::int32_t dx = -2; dx <= 2; ++dx) {
          const auto found = there.find(KeyOf({v.x + dx, v.y + dy, v.z + dz}));
          if (found == there.end()) continue;
          heaviest = std::max(heaviest, found->second);
          if (std::abs(dx) <= 1 && std::abs(dy) <= 1) ++near;
        }
    if (near >= options.company && points[i].weight >= options.min_skirt_share * heaviest)
      kept.push_back(i);
  }
  return kept;
}

/// Share of the squares within half a metre around its foot whose ground was seen.
double GroundAround(const ChangeRegion& region, const ChangePoints& look) {
  constexpr double kAround = 0.5;
  Eigen::Vector2d low = region.points.front().position_m.head<2>(), high = low;
  for (const ChangePoint& p : region.points) {
    low = low.cwiseMin(p.position_m.head<2>());
    high = high.cwiseMax(p.position_m.head<2>());
  }
  int all = 0, seen = 0;
  const Eigen::Vector2d first = low - Eigen::Vector2d::Constant(kAround);
  const Eigen::Vector2d size = high - low + Eigen::Vector2d::Constant(2.0 * kAround);
  const int columns = 1 + static_cast<int>(size.x() / ChangePoints::kGroundCell);
  const int rows = 1 + static_cast<int>(size.y() / ChangePoints::kGroundCell);
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      ++all;
      seen += look.GroundSeen(first + ChangePoints::kGroundCell * Eigen::Vector2d(i, j)) ? 1 : 0;
    }
  return static_cast<double>(seen) / all;
}

double LowestHeight(const ChangeRegion& region) {
  std::vector<double> heights;
  for (const ChangePoint& p : region.points) heights.push_back(p.height_m);
  const auto tenth = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 10);
  std::nth_element(heights.begin(), tenth, heights.end());
  return *tenth;
}

}  // namespace

std::vector<ChangeRegion> LabelRegions(const ChangePoints& look, double voxel_m,
                                       const RegionOptions& options) {
  const std::vector<ChangePoint>& points = look.points;
  std::map<Square, Column> columns;
  for (const std::size_t i : Accompanied(points, options)) {
    const ChangePoint& p = points[i];
    const Square square{static_cast<std::int32_t>(std::floor(p.position_m.x() / options.column_m)),
                        static_cast<std::int32_t>(std::floor(p.position_m.y() / options.column_m))};
    Column& column = columns[square];
    column.points.push_back(i);
    // One voxel one vote: near surfaces have thousands of times the votes of far ones.
    column.mean += p.position_m.head<2>();
    column.weight += 1.0;
  }
  std::vector<const Column*> order;
  std::map<Square, std::size_t> place;
  for (auto& [square, column] : columns) {
    column.mean /= column.weight;
    place[square] = order.size();
    order.push_back(&column);
  }
  DisjointSets sets(order.size());
  const auto reach = static_cast<std::int32_t>(std::ceil(options.link_m / options.column_m));
  for (const auto& [square, at] : place) {
    for (std::int32_t dx = 0; dx <= reach; ++dx)
      for (std::int32_t dy = dx == 0 ? 1 : -reach; dy <= reach; ++dy) {
        const auto other = place.find({square.first + dx, square.second + dy});
        if (other == place.end()) continue;
        if ((order[at]->mean - order[other->second]->mean).norm() <= options.link_m)
          sets.Join(at, other->second);
      }
  }
  std::map<std::size_t, ChangeRegion> regions;
  for (std::size_t i = 0; i < order.size(); ++i) {
    ChangeRegion& region = regions[sets.Find(i)];
    for (const std::size_t p : order[i]->points) region.points.push_back(points[p]);
  }
  std::vector<ChangeRegion> kept;
  for (auto& [root, region] : regions) {
    const double surface_m2 = static_cast<double>(region.points.size()) * voxel_m * voxel_m;
    if (surface_m2 < options.min_surface_m2) continue;
    if (LowestHeight(region) > options.overhead_m) continue;
    if (surface_m2 < options.min_hidden_m2 && GroundAround(region, look) < options.min_ground_share)
      continue;
    kept.push_back(std::move(region));
  }
  std::stable_sort(kept.begin(), kept.end(), [](const ChangeRegion& a, const ChangeRegion& b) {
    return a.points.size() > b.points.size();
  });
  return kept;
}

}  // namespace kawara::vision
