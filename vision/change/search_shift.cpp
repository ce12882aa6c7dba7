#include "vision/change/search_shift.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace kawara::vision {
namespace {

constexpr float kUpright = 0.5F;  // of a normal's height: steeper surfaces only
constexpr float kThick = 0.15F;   // m: voxels of trees and heaps have no plane to lie on
constexpr double kOverhang = ReferenceMap::kVoxel / 4;  // m: a plane goes on beyond its voxel

struct Upright {
  Eigen::Vector3d centre, mean, normal;
};

std::vector<Upright> UprightsAbout(const Eigen::Vector3d& p, const ReferenceMap& reference,
                                   double reach_m) {
  std::vector<Upright> all;
  const Eigen::Vector3d reach(reach_m, reach_m, 0.0);
  const VoxelIndex low = ReferenceMap::VoxelOf(p - reach);
  const VoxelIndex high = ReferenceMap::VoxelOf(p + reach);
  for (std::int32_t z = low.z; z <= high.z; ++z)
    for (std::int32_t y = low.y; y <= high.y; ++y)
      for (std::int32_t x = low.x; x <= high.x; ++x) {
        const ReferencePatch* const patch = reference.Find({x, y, z});
        if (patch == nullptr || std::abs(patch->normal.z()) > kUpright ||
            patch->thickness_m > kThick)
          continue;
        const Eigen::Vector3d centre =
            Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5) * ReferenceMap::kVoxel;
        all.push_back(
            {centre, centre + patch->mean_m.cast<double>(), patch->normal.cast<double>()});
      }
  return all;
}

/// Infinite: on none.
double SquaredOffPlane(const Eigen::Vector3d& p, const std::vector<Upright>& uprights) {
  double least = 1e9;
  for (const Upright& upright : uprights) {
    const double along = (p - upright.mean).dot(upright.normal);
    if (along * along >= least) continue;
    const Eigen::Vector3d foot = p - along * upright.normal;
    if ((foot - upright.centre).cwiseAbs().maxCoeff() > ReferenceMap::kVoxel / 2 + kOverhang)
      continue;
    least = along * along;
  }
  return least;
}

}  // namespace

ShiftFound SearchShift(const std::vector<Eigen::Vector3d>& points, const ReferenceMap& reference,
                       const ShiftSearchOptions& options) {
  ShiftFound found;
  struct Tried {
    Eigen::Vector3d shift_m;
    double nats;
  };
  std::vector<Tried> all{{Eigen::Vector3d::Zero(), 0.0}};
  const int steps = static_cast<int>(std::lround(options.reach_m / options.step_m));
  for (int north = -steps; north <= steps; ++north)
    for (int east = -steps; east <= steps; ++east)
      if (east != 0 || north != 0)
        all.push_back({options.step_m * Eigen::Vector3d(east, north, 0.0), 0.0});
  const double per_m2 = 0.5 / (options.scale_m * options.scale_m);
  for (const Eigen::Vector3d& p : points) {
    const auto uprights = UprightsAbout(p, reference, options.reach_m + ReferenceMap::kVoxel / 2);
    if (uprights.empty()) continue;
    ++found.surfaces;
    for (Tried& tried : all) {
      const double exponent = per_m2 * SquaredOffPlane(p + tried.shift_m, uprights);
      if (exponent < 20.0) tried.nats += std::log1p(options.odds * std::exp(-exponent));
    }
  }
  // Of equals, as along a straight wall, the smallest.
  constexpr double kEqual = 1e-9;
  found.nats = found.nats_without = all.front().nats;
  for (const Tried& tried : all) {
    const bool better = tried.nats > found.nats + kEqual;
    const bool as_good = tried.nats > found.nats - kEqual;
    const bool smaller = tried.shift_m.norm() < found.shift_m.norm();
    if (!better && !(as_good && smaller)) continue;
    found.nats = tried.nats;
    found.shift_m = tried.shift_m.head<2>();
  }
  return found;
}

}  // namespace kawara::vision
