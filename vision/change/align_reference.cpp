#include "vision/change/align_reference.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "core/geodesy.hpp"

namespace kawara::vision {
namespace {

constexpr int kRounds = 10;
constexpr double kReach = 0.9;   // m: how far surfaces may be from where they belong
constexpr double kThick = 0.15;  // m: voxels of trees and heaps have no plane to lie on
// Weight of a residual r: 1 / (1 + (r / scale)^2)^2 (Geman and McClure), the scale falling from
// round to round, so that what has changed or was never in the reference counts less and less.
constexpr double kFirstScale = 0.40, kLastScale = 0.06, kScaleStep = 0.6;  // m
constexpr double kLeastGain = 0.05;  // of the residuals' cost: less is no shift but chance
constexpr std::size_t kLeast = 50;
constexpr std::size_t kMost = 6000;
// Neighbouring voxels err together: so many count as one.
constexpr double kCorrelated = 50.0;

struct Residual {
  double m = 0.0;
  Eigen::Vector4d slope;  ///< by east, north, up, turn
};

std::vector<Eigen::Vector3d> SurfacesAbout(const VoxelMap& map, const RoadArea& road,
                                           const OccupancyRule& rule, double around_m) {
  std::vector<Eigen::Vector3d> points;
  const double voxel_m = map.config().voxel_m;
  map.ForEachOccupied(rule, [&](const OccupiedVoxel& occupied) {
    const Eigen::Vector3d p = CentroidVoxels(occupied.index, occupied.voxel) * voxel_m;
    const Eigen::Vector2d beyond =
        (road.min_m() - p.head<2>()).cwiseMax(p.head<2>() - road.max_m()).cwiseMax(0.0);
    if (beyond.norm() <= around_m) points.push_back(p);
  });
  if (points.size() > kMost) {  // evenly, so that the same map gives the same answer
    const std::size_t step = points.size() / kMost + 1;
    std::vector<Eigen::Vector3d> fewer;
    for (std::size_t i = 0; i < points.size(); i += step) fewer.push_back(points[i]);
    points = std::move(fewer);
  }
  return points;
}

std::vector<Residual> Residuals(const std::vector<Eigen::Vector3d>& points,
                                const Eigen::Isometry3d& reference_from_map,
                                const Eigen::Vector3d& middle, const ReferenceMap& reference) {
  std::vector<Residual> all;
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d q = reference_from_map * p;
    Residual r;
    Eigen::Vector3d normal;
    if (const auto match = reference.Nearest(q, kReach); match) {
      if (match->sd_m > kThick) continue;
      normal = match->normal;
      r.m = match->signed_m;
    } else if (const auto ground = reference.ground.At(q.head<2>());
               ground && std::abs(q.z() - ground->up_m) < kReach) {
      normal = Eigen::Vector3d::UnitZ();
      r.m = q.z() - ground->up_m;
    } else {
      continue;
    }
    const Eigen::Vector3d arm = q - middle;
    r.slope << normal, normal.x() * -arm.y() + normal.y() * arm.x();
    all.push_back(r);
  }
  return all;
}

double CostOf(const std::vector<Residual>& residuals, double scale) {
  double cost = 0.0;
  for (const Residual& r : residuals) {
    const double q = r.m * r.m / (scale * scale);
    cost += q / (1.0 + q);
  }
  return cost;
}

double MedianOf(const std::vector<Residual>& residuals) {
  std::vector<double> sizes;
  sizes.reserve(residuals.size());
  for (const Residual& r : residuals) sizes.push_back(std::abs(r.m));
  const auto half = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), half, sizes.end());
  return *half;
}

}  // namespace

core::Expected<Alignment> AlignReference(const VoxelMap& map, const KnownPlace& place,
                                         const OccupancyRule& rule, const AlignOptions& options) {
  Alignment result;
  const ReferenceMap& reference = place.reference;
  const auto points = SurfacesAbout(map, place.road, rule, options.around_m);
  if (points.empty()) return result;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) middle += p / static_cast<double>(points.size());

  Eigen::Vector4d state = Eigen::Vector4d::Zero();
  const auto pose = [&] {
    Eigen::Isometry3d t = Eigen::Isometry3d::Identity();
    t.linear() = Eigen::AngleAxisd(state[3], Eigen::Vector3d::UnitZ()).toRotationMatrix();
    t.translation() = middle + state.head<3>() - t.linear() * middle;
    return t;
  };
  Eigen::Vector4d prior;
  prior << Eigen::Vector3d::Constant(1.0 / (options.prior_sd_m * options.prior_sd_m)),
      1.0 / (options.prior_turn_sd_rad * options.prior_turn_sd_rad);
  Eigen::Matrix4d information = prior.asDiagonal();
  double scale = kFirstScale;
  double cost_before = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    const auto residuals = Residuals(points, pose(), middle, reference);
    result.surfaces = residuals.size();
    if (residuals.size() < kLeast) return result;
    if (round == 0) {
      result.residual_before_m = MedianOf(residuals);
      cost_before = CostOf(residuals, kLastScale) / static_cast<double>(residuals.size());
    }
    const double sd = std::max(0.02, 1.4826 * MedianOf(residuals));
    information = prior.asDiagonal();
    Eigen::Vector4d gradient = -prior.cwiseProduct(state);
    for (const Residual& r : residuals) {
      const double share = 1.0 / (1.0 + r.m * r.m / (scale * scale));
      const double weight = share * share / (sd * sd * kCorrelated);
      information += weight * r.slope * r.slope.transpose();
      gradient -= weight * r.m * r.slope;
    }
    state += information.ldlt().solve(gradient);
    scale = std::max(kLastScale, kScaleStep * scale);
  }
  const auto residuals = Residuals(points, pose(), middle, reference);
  result.surfaces = residuals.size();
  if (residuals.size() < kLeast) return result;
  result.residual_m = MedianOf(residuals);
  if (CostOf(residuals, kLastScale) / static_cast<double>(residuals.size()) >
      (1.0 - kLeastGain) * cost_before) {
    result.residual_m = result.residual_before_m;
    return result;
  }
  result.reference_from_map = pose();
  result.shift_m = state.head<3>();
  result.turn_rad = state[3];
  result.shift_sd_m = information.inverse().diagonal().head<3>().cwiseSqrt();
  if (result.shift_m.cwiseAbs().maxCoeff() > options.max_shift_m ||
      std::abs(result.turn_rad) > options.max_turn_rad) {
    std::array<char, 256> text{};
    std::snprintf(text.data(), text.size(),
                  "the robot's surfaces lie %+.2f m east, %+.2f m north, %+.2f m up and %+.2f deg "
                  "off the reference's: beyond reason (%.2f m, %.1f deg); other poses or another "
                  "reference are needed",
                  -state[0], -state[1], -state[2], -state[3] * core::kDegFromRad,
                  options.max_shift_m, options.max_turn_rad * core::kDegFromRad);
    return core::Fail(core::ErrorCode::kInvalidArgument, text.data());
  }
  return result;
}

}  // namespace kawara::vision
