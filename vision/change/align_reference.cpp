#include "vision/change/align_reference.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "core/geodesy.hpp"
#include "vision/change/search_shift.hpp"

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
constexpr std::size_t kMost = 3000;  // of the low ones, and of the high ones
constexpr double kLevel = 0.97;      // of a normal's height: 14 degrees
constexpr double kHigh = 0.3;        // m above the ground
// A shift of decimetres against a fix and a survey of centimetres happens once in some thousands.
constexpr double kLeastNats = 8.0;
constexpr double kWrongSd = 1.0;       // m: where the map may lie then
constexpr double kCoarseScale = 0.15;  // m
// Neighbouring voxels err together: so many count as one.
constexpr double kCorrelated = 50.0;

struct Residual {
  double m = 0.0;
  Eigen::Vector4d slope;  ///< by east, north, up, turn
};

/// Evenly, so that the same map gives the same answer.
void Thin(std::vector<Eigen::Vector3d>& points, std::size_t most) {
  if (points.size() <= most) return;
  const std::size_t step = points.size() / most + 1;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.size(); i += step) points[kept++] = points[i];
  points.resize(kept);
}

/// Surface points of the map about the road. Those that stand up from the ground are few and alone
/// say where the map lies in the plane: thinned apart, so that the ground does not crowd them out.
struct Surfaces {
  std::vector<Eigen::Vector3d> low, high;
};

Surfaces SurfacesAbout(const VoxelMap& map, const KnownPlace& place, const OccupancyRule& rule,
                       double around_m) {
  Surfaces surfaces;
  const double voxel_m = map.config().voxel_m;
  const RoadArea& road = place.road;
  map.ForEachOccupied(rule, [&](const OccupiedVoxel& occupied) {
    const Eigen::Vector3d p = CentroidVoxels(occupied.index, occupied.voxel) * voxel_m;
    const Eigen::Vector2d beyond =
        (road.min_m() - p.head<2>()).cwiseMax(p.head<2>() - road.max_m()).cwiseMax(0.0);
    if (beyond.norm() > around_m) return;
    const auto ground = place.reference.ground.At(p.head<2>());
    (ground && p.z() - ground->up_m < kHigh ? surfaces.low : surfaces.high).push_back(p);
  });
  Thin(surfaces.low, kMost);
  Thin(surfaces.high, kMost);
  return surfaces;
}

/// Where the descent begins: where the uprights speak for it against the little that is likely.
Eigen::Vector2d CoarseShift(const std::vector<Eigen::Vector3d>& high, const VoxelMap& map,
                            const ReferenceMap& reference) {
  const ShiftFound found = SearchShift(high, reference, {});
  // Voxels on one patch of the reference share its error: they count as one.
  const double side = std::max(1.0, ReferenceMap::kVoxel / map.config().voxel_m);
  if ((found.nats - found.nats_without) / (side * side) < kLeastNats)
    return Eigen::Vector2d::Zero();
  return found.shift_m;
}

core::Error BeyondReason(const Eigen::Vector4d& state, const AlignOptions& options) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(),
                "the robot's surfaces lie %+.2f m east, %+.2f m north, %+.2f m up and %+.2f deg "
                "off the reference's: beyond reason (%.2f m, %.1f deg); other poses or another "
                "reference are needed",
                -state[0], -state[1], -state[2], -state[3] * core::kDegFromRad, options.max_shift_m,
                options.max_turn_rad * core::kDegFromRad);
  return {core::ErrorCode::kInvalidArgument, text.data()};
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
      // Many small false tilts of level patches would look like knowledge of the plane.
      normal = std::abs(match->normal.z()) > kLevel
                   ? Eigen::Vector3d(0.0, 0.0, match->normal.z() > 0.0 ? 1.0 : -1.0)
                   : match->normal;
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
  result.plane_covariance_m2 =
      options.prior_sd_m * options.prior_sd_m * Eigen::Matrix2d::Identity();
  result.shift_sd_m = Eigen::Vector3d::Constant(options.prior_sd_m);
  auto [points, high] = SurfacesAbout(map, place, rule, options.around_m);
  points.insert(points.end(), high.begin(), high.end());
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
  double scale = kFirstScale;
  double cost_before = 0.0;
  const Eigen::Vector2d coarse = CoarseShift(high, map, reference);
  if (!coarse.isZero()) {
    // Something is wrong: what is supposed of a good fix does not hold, and the valley is known.
    prior.head<2>().setConstant(1.0 / (kWrongSd * kWrongSd));
    scale = kCoarseScale;
  }
  Eigen::Matrix4d information = prior.asDiagonal();
  for (int round = 0; round < kRounds; ++round) {
    const auto residuals = Residuals(points, pose(), middle, reference);
    result.surfaces = residuals.size();
    if (residuals.size() < kLeast) return result;
    if (round == 0) {
      result.residual_before_m = MedianOf(residuals);
      cost_before = CostOf(residuals, kLastScale) / static_cast<double>(residuals.size());
      if (!coarse.isZero()) {
        state.head<2>() = coarse;
        continue;
      }
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
  const Eigen::Matrix4d covariance = information.inverse();
  result.shift_sd_m = covariance.diagonal().head<3>().cwiseSqrt();
  result.plane_covariance_m2 = covariance.topLeftCorner<2, 2>();
  if (coarse.isZero() && CostOf(residuals, kLastScale) / static_cast<double>(residuals.size()) >
                             (1.0 - kLeastGain) * cost_before) {
    result.residual_m = result.residual_before_m;
    return result;
  }
  result.reference_from_map = pose();
  result.shift_m = state.head<3>();
  result.turn_rad = state[3];
  if (result.shift_m.cwiseAbs().maxCoeff() > options.max_shift_m ||
      std::abs(result.turn_rad) > options.max_turn_rad)
    return tl::unexpected(BeyondReason(state, options));
  return result;
}

std::string Unchecked(const Alignment& alignment) {
  constexpr double kSeen = 0.10;  // m
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(alignment.plane_covariance_m2);
  const double sd_m = std::sqrt(std::max(0.0, axes.eigenvalues()[1]));
  if (sd_m <= kSeen) return {};
  std::array<char, 200> text{};
  const bool everywhere = std::sqrt(std::max(0.0, axes.eigenvalues()[0])) > kSeen;
  const Eigen::Vector2d along = axes.eigenvectors().col(1);
  const double bearing = std::atan2(along.x(), along.y()) * core::kDegFromRad;
  if (everywhere)
    std::snprintf(text.data(), text.size(),
                  "too little stands upright near the road to tell a shift in the plane: %.2f m "
                  "(one deviation) are allowed for",
                  sd_m);
  else
    std::snprintf(text.data(), text.size(),
                  "too little stands upright near the road to tell a shift along the line at %.0f "
                  "deg from north: %.2f m (one deviation) are allowed for",
                  bearing < 0.0 ? bearing + 180.0 : bearing, sd_m);
  return text.data();
}

}  // namespace kawara::vision
