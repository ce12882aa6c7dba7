#include "sim/evaluate/cloud_errors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nanoflann.hpp>
#include <set>

namespace kawara::sim {
namespace {

using Cloud = std::vector<Eigen::Vector3d>;

/// What nanoflann asks of a set of points.
struct PointSet {
  const Cloud& points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t dimension) const {
    return points[i][static_cast<Eigen::Index>(dimension)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;
  }
};

/// Of every point of `from` to the nearest of `to`.
std::vector<double> Distances(const Cloud& from, const Cloud& to) {
  const PointSet set{to};
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointSet>,
                                                   PointSet, 3, std::size_t>;
  const Tree tree(3, set, nanoflann::KDTreeSingleIndexAdaptorParams(16));
  std::vector<double> distances;
  distances.reserve(from.size());
  for (const Eigen::Vector3d& point : from) {
    std::size_t index = 0;
    double squared = 0.0;
    tree.knnSearch(point.data(), 1, &index, &squared);
    distances.push_back(std::sqrt(squared));
  }
  return distances;
}

double ShareBelow(const std::vector<double>& distances, double limit) {
  const auto n =
      std::count_if(distances.begin(), distances.end(), [limit](double d) { return d < limit; });
  return static_cast<double>(n) / static_cast<double>(distances.size());
}

using Voxel = std::array<std::int64_t, 3>;

std::vector<Voxel> VoxelsOf(const Cloud& cloud, double voxel_m) {
  std::vector<Voxel> voxels;
  voxels.reserve(cloud.size());
  for (const Eigen::Vector3d& p : cloud) {
    voxels.push_back({static_cast<std::int64_t>(std::floor(p.x() / voxel_m)),
                      static_cast<std::int64_t>(std::floor(p.y() / voxel_m)),
                      static_cast<std::int64_t>(std::floor(p.z() / voxel_m))});
  }
  std::sort(voxels.begin(), voxels.end());
  voxels.erase(std::unique(voxels.begin(), voxels.end()), voxels.end());
  return voxels;
}

}  // namespace

core::Expected<ErrorReport> CompareClouds(const Cloud& truth, const Cloud& result, double voxel_m) {
  if (truth.empty() || result.empty()) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      truth.empty() ? "the truth has no points" : "the result has no points");
  }
  const std::vector<double> accuracy = Distances(result, truth);
  const std::vector<double> completeness = Distances(truth, result);
  ErrorReport report;
  report.Add("accuracy (result to truth)", "m", Summarise(accuracy));
  report.Add("completeness (truth to result)", "m", Summarise(completeness));
  for (const double limit : {0.05, 0.1, 0.2, 0.5}) {
    const double precision = ShareBelow(accuracy, limit);
    const double recall = ShareBelow(completeness, limit);
    const double f = precision + recall > 0 ? 2 * precision * recall / (precision + recall) : 0.0;
    char name[48];
    std::snprintf(name, sizeof(name), " within %g cm", limit * 100);
    report.Add(std::string("precision") + name, "share", precision);
    report.Add(std::string("recall") + name, "share", recall);
    report.Add(std::string("F") + name, "share", f);
  }
  const std::vector<Voxel> right = VoxelsOf(truth, voxel_m);
  const std::vector<Voxel> got = VoxelsOf(result, voxel_m);
  std::vector<Voxel> shared;
  std::set_intersection(right.begin(), right.end(), got.begin(), got.end(),
                        std::back_inserter(shared));
  const auto n = static_cast<double>(shared.size());
  report.Add("voxels right (of the result's)", "share", n / static_cast<double>(got.size()));
  report.Add("voxels found (of the truth's)", "share", n / static_cast<double>(right.size()));
  report.Add("voxels shared (of either's)", "share",
             n / static_cast<double>(right.size() + got.size() - shared.size()));
  return report;
}

}  // namespace kawara::sim
