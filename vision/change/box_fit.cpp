#include "vision/change/box_fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/geodesy.hpp"
#include "vision/change/side_profile.hpp"

namespace kawara::vision {
namespace {

constexpr double kStep = 0.02;          // m, of profiles
constexpr double kSideDepth = 0.6;      // m: how deep in a side's peak may lie
constexpr double kSharp = 1.5;          // of a side over the mean density
constexpr double kNearSide = 0.25;      // m: points of a side
constexpr double kLeastCover = 0.4;     // of a side's length
constexpr double kCutShort = 0.30;      // m from the edge of what was searched
constexpr double kFaceEndSd = 0.20;     // m: of where a side seen at a slant ends
constexpr double kInside = 0.25;        // share of points on no side
constexpr double kSecondHeading = 3.0;  // log-likelihood that it may lack
constexpr double kQuarter = core::kPi / 2.0;

/// Columns of numbers for the inner loops; `east_m`, `north_m` from the region's mean.
struct Points {
  std::vector<double> east_m, north_m, height_m, weight, unit, noise_m;
  std::vector<Eigen::Vector2d> to_viewer;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double independent = 0.0;  ///< points, correlation taken off

  Points(const ChangeRegion& region, const BoxOptions& options) {
    for (const ChangePoint& p : region.points) centre += p.position_m.head<2>();
    centre /= static_cast<double>(region.points.size());
    std::vector<double> weights;
    for (const ChangePoint& p : region.points) weights.push_back(p.weight);
    const auto middle = weights.begin() + static_cast<std::ptrdiff_t>(weights.size() / 2);
    std::nth_element(weights.begin(), middle, weights.end());
    const double most = 9.0 * *middle;
    double sum = 0.0, sum2 = 0.0;
    for (const ChangePoint& p : region.points) {
      east_m.push_back(p.position_m.x() - centre.x());
      north_m.push_back(p.position_m.y() - centre.y());
      height_m.push_back(p.height_m);
      // What was seen from very near must not be all that counts.
      weight.push_back(std::sqrt(std::min(p.weight, most)));
      unit.push_back(1.0);
      noise_m.push_back(std::min(p.vote_sd_m, 0.3));
      to_viewer.emplace_back(p.to_viewer.head<2>());
      sum += weight.back();
      sum2 += weight.back() * weight.back();
    }
    independent = std::max(2.0, sum * sum / sum2 / options.correlated_voxels);
  }
  std::size_t size() const { return east_m.size(); }
};

/// The points along one axis and its two sides.
struct Axis {
  std::vector<double> at_m;
  SideProfile votes, voxels;
  SidePeak upper, lower;

  explicit Axis(double voxel_m)
      : votes(kStep, std::max(0.03, 0.25 * voxel_m)),
        voxels(kStep, std::max(0.04, 0.35 * voxel_m)) {}
  void Fill(const Points& points, const Eigen::Vector2d& direction) {
    at_m.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
      at_m[i] = direction.x() * points.east_m[i] + direction.y() * points.north_m[i];
    votes.Fill(at_m, points.weight);
    upper = votes.Upper(kSideDepth);
    lower = votes.Lower(kSideDepth);
  }
};

Eigen::Vector2d Direction(double heading_rad) {
  return {std::sin(heading_rad), std::cos(heading_rad)};
}

/// Into [0, period).
double Fold(double angle, double period) {
  const double folded = std::fmod(angle, period);
  return folded < 0.0 ? folded + period : folded;
}

/// Things stand along the road, some across, and any way: log density of a heading, the same after
/// half a turn.
double LogRoad(double heading_rad, const BoxOptions& options) {
  if (!options.road_heading_rad) return 0.0;
  constexpr double kAlong = 0.50, kAcross = 0.10;
  const double sd = options.road_heading_sd_rad;
  const auto bell = [&](double turned_rad) {
    const double off =
        core::WrapPi(2.0 * (heading_rad - *options.road_heading_rad - turned_rad)) / 2.0;
    return std::exp(-0.5 * off * off / (sd * sd)) / (sd * std::sqrt(2.0 * core::kPi));
  };
  return std::log(kAlong * bell(0.0) + kAcross * bell(kQuarter) +
                  (1.0 - kAlong - kAcross) / core::kPi);
}

/// Log-likelihood that the points lie on the sides of a box with this heading.
class HeadingScore {
 public:
  HeadingScore(const Points& points, const BoxOptions& options)
      : points_(points), options_(options), along_(options.voxel_m), across_(options.voxel_m) {
    for (const double w : points.weight) sum_ += w;
  }

  double operator()(double heading_rad) {
    along_.Fill(points_, Direction(heading_rad));
    across_.Fill(points_, Direction(heading_rad - kQuarter));
    const double extent = along_.upper.outermost_m - along_.lower.outermost_m +
                          across_.upper.outermost_m - across_.lower.outermost_m;
    const double inside = kInside / std::max(0.5, extent / 4.0);
    double score = 0.0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const double sd = std::hypot(0.05 + 0.1 * options_.voxel_m, 0.5 * points_.noise_m[i]);
      double density = inside;
      for (const Axis* axis : {&along_, &across_}) {
        density += SideDensity(axis->at_m[i] - axis->upper.at_m, axis->upper, sd);
        density += SideDensity(axis->at_m[i] - axis->lower.at_m, axis->lower, sd);
      }
      score += points_.weight[i] * std::log(density);
    }
    return points_.independent * score / sum_ + LogRoad(heading_rad, options_);
  }

 private:
  static double SideDensity(double off_m, const SidePeak& side, double sd) {
    // A side without a peak gathers nothing by design of this factor.
    const double share = std::clamp((side.sharpness - 1.0) / 2.0, 0.05, 1.0);
    const double z = off_m / sd;
    return z * z > 30.0 ? 0.0
                        : share * (1.0 - kInside) / 4.0 * std::exp(-0.5 * z * z) / (sd * 2.5066);
  }
  const Points& points_;
  const BoxOptions& options_;
  Axis along_, across_;
  double sum_ = 0.0;
};

struct Headings {
  double best_rad = 0.0, sd_rad = 0.01;
  std::optional<double> second_rad;
};

Headings SearchHeading(const Points& points, const BoxOptions& options) {
  HeadingScore score(points, options);
  constexpr int kCoarse = 90;
  constexpr double kCoarseStep = core::kPi / kCoarse;  // 2 deg, over half a turn
  std::vector<double> coarse;
  coarse.reserve(kCoarse);
  // Sides are the same after a quarter turn, the road is not: half a turn is searched.
  for (int i = 0; i < kCoarse; ++i) coarse.push_back(score(i * kCoarseStep));
  const auto best = std::max_element(coarse.begin(), coarse.end());
  Headings result;
  const double about = static_cast<double>(best - coarse.begin()) * kCoarseStep;
  constexpr double kFine = 0.1 * core::kRadFromDeg;
  constexpr int kFineReach = 25;
  std::vector<double> fine;
  for (int i = -kFineReach; i <= kFineReach; ++i) fine.push_back(score(about + i * kFine));
  const double most = *std::max_element(fine.begin(), fine.end());
  double sum = 0.0, mean = 0.0, square = 0.0;
  for (int i = 0; i < static_cast<int>(fine.size()); ++i) {
    const double share = std::exp(fine[static_cast<std::size_t>(i)] - most);
    const double angle = (i - kFineReach) * kFine;
    sum += share;
    mean += share * angle;
    square += share * angle * angle;
  }
  mean /= sum;
  result.best_rad = about + mean;
  result.sd_rad = std::sqrt(std::max(square / sum - mean * mean, kFine * kFine));
  // Another heading, not a quarter turn away, that explains nearly as much.
  double other_best = -1e300;
  for (int i = 0; i < kCoarse; ++i) {
    const double off = std::abs(core::WrapPi(4.0 * (i * kCoarseStep - result.best_rad)) / 4.0);
    if (off < 10.0 * core::kRadFromDeg) continue;
    const double here = coarse[static_cast<std::size_t>(i)];
    if (here < coarse[static_cast<std::size_t>((i + kCoarse - 1) % kCoarse)] ||
        here < coarse[static_cast<std::size_t>((i + 1) % kCoarse)])
      continue;
    if (here > most - kSecondHeading && here > other_best) {
      other_best = here;
      result.second_rad = i * kCoarseStep;
    }
  }
  return result;
}

/// One end of the box along an axis.
struct Side {
  double at_m = 0.0, sd_m = 0.1;
  bool seen = false;   ///< as a plane
  bool ended = false;  ///< as a plane, or as an end that somebody looked at: a sloping bonnet
  bool was_cut = false;
  bool by_face = false;  ///< not itself, but a plane beside it was seen, which ends there
};

class SideFinder {
 public:
  SideFinder(const Points& points, const BoxOptions& options,
             const std::function<double(const Eigen::Vector2d&)>& cut_m)
      : points_(points), options_(options), cut_m_(cut_m) {}

  /// `sign`: +1 the upper end. `other`: the other axis.
  Side Find(Axis& axis, const Axis& other, const Eigen::Vector2d& direction, double sign) const {
    const SidePeak& peak = sign > 0 ? axis.upper : axis.lower;
    Side side;
    const Look plane =
        LookAt(axis, other, direction, sign, peak.at_m - kNearSide, peak.at_m + kNearSide);
    side.seen = peak.sharpness > kSharp && plane.cover >= kLeastCover && plane.looked_at;
    if (side.seen) {
      side.ended = true;
      side.at_m = peak.at_m;
      const double scatter = std::sqrt(plane.spread / plane.near + 1e-6);
      side.sd_m = scatter / std::sqrt(std::max(1.0, plane.near / options_.correlated_voxels));
      return side;
    }
    axis.voxels.Fill(axis.at_m, points_.unit);
    side.at_m = sign > 0 ? axis.voxels.UpperEdge() : axis.voxels.LowerEdge();
    side.sd_m = kEdgeSd;
    const Look end =
        LookAt(axis, other, direction, sign, side.at_m - kDeepEnd, side.at_m + kDeepEnd);
    side.ended = end.looked_at && end.cover >= kLeastCover;
    side.was_cut = end.was_cut;
    return side;
  }

 private:
  static constexpr double kCoverStep = 0.25;
  static constexpr double kLeastFacing = 0.1;
  static constexpr double kDeepEnd = 0.5;
  static constexpr double kEdgeSd = 0.12;

  /// Points within a slice across an axis.
  struct Look {
    double near = 0.0;       ///< how many
    double spread = 0.0;     ///< sum of squares from the middle
    double cover = 0.0;      ///< share of the slice's length that has any
    bool was_cut = false;    ///< by the area's edge
    bool looked_at = false;  ///< from outside, and not cut off by the area's edge
  };
  Look LookAt(const Axis& axis, const Axis& other, const Eigen::Vector2d& direction, double sign,
              double from_m, double to_m) const {
    Look look;
    double facing = 0.0, known = 0.0, cut = 0.0;
    const double middle = (from_m + to_m) / 2.0;
    std::vector<bool> covered(static_cast<std::size_t>(
        std::max(1.0, (other.upper.at_m - other.lower.at_m) / kCoverStep)));
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (axis.at_m[i] < from_m || axis.at_m[i] > to_m) continue;
      const double off = axis.at_m[i] - middle;
      look.near += 1.0;
      look.spread += off * off;
      if (points_.to_viewer[i].squaredNorm() > 0.0) {
        facing += sign * points_.to_viewer[i].dot(direction);
        known += 1.0;
      }
      const double place = (other.at_m[i] - other.lower.at_m) / kCoverStep;
      if (place >= 0.0 && place < static_cast<double>(covered.size()))
        covered[static_cast<std::size_t>(place)] = true;
      const Eigen::Vector2d at =
          points_.centre + Eigen::Vector2d(points_.east_m[i], points_.north_m[i]);
      if (cut_m_(at) < kCutShort) cut += 1.0;
    }
    look.cover = static_cast<double>(std::count(covered.begin(), covered.end(), true)) /
                 static_cast<double>(covered.size());
    const bool turned_away = known > 0.5 * look.near && facing < kLeastFacing * known;
    look.was_cut = cut > 0.5 * look.near;
    look.looked_at = look.near > 0.0 && !turned_away && !look.was_cut;
    return look;
  }

  const Points& points_;
  const BoxOptions& options_;
  const std::function<double(const Eigen::Vector2d&)>& cut_m_;
};

/// The box at one heading: what was seen, then what such things measure.
struct Candidate {
  double heading_rad = 0.0;
  std::array<Side, 4> sides;  ///< front, left, rear, right: positions along forward, and left
  double height_m = 0.0, height_sd_m = 0.05;
  bool top_seen = false;
  SizeGuess size;
};

double Regular(const Points& points, const Axis& along, const Axis& across, double height_m) {
  double on = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double off = std::min(
        {std::abs(along.at_m[i] - along.upper.at_m), std::abs(along.at_m[i] - along.lower.at_m),
         std::abs(across.at_m[i] - across.upper.at_m), std::abs(across.at_m[i] - across.lower.at_m),
         std::abs(points.height_m[i] - height_m)});
    if (off < 0.12 + 0.5 * points.noise_m[i]) on += 1.0;
  }
  return std::clamp((on / static_cast<double>(points.size()) - 0.4) / 0.35, 0.0, 1.0);
}

Candidate Measure(const Points& points, const BoxOptions& options,
                  const std::function<double(const Eigen::Vector2d&)>& cut_m, double heading_rad) {
  Candidate c;
  c.heading_rad = heading_rad;
  const Eigen::Vector2d forward = Direction(heading_rad), left = Direction(heading_rad - kQuarter);
  Axis along(options.voxel_m), across(options.voxel_m), up(options.voxel_m);
  along.Fill(points, forward);
  across.Fill(points, left);
  const SideFinder finder(points, options, cut_m);
  c.sides[0] = finder.Find(along, across, forward, 1.0);
  c.sides[1] = finder.Find(across, along, left, 1.0);
  c.sides[2] = finder.Find(along, across, forward, -1.0);
  c.sides[3] = finder.Find(across, along, left, -1.0);
  up.votes.Fill(points.height_m, points.weight);
  up.voxels.Fill(points.height_m, points.unit);
  const SidePeak top = up.votes.Upper(0.4);
  c.top_seen = top.sharpness > 2.0;
  c.height_m = c.top_seen ? std::max(top.at_m, up.voxels.UpperEdge() - 0.1) : up.voxels.UpperEdge();
  const double regular = Regular(points, along, across, c.height_m);
  // Who sees a plane side sees all of it: the box reaches from its one edge to the other.
  for (std::size_t i = 0; i < 4; ++i) {
    Side& end = c.sides[i];
    if (end.ended || end.was_cut || !(c.sides[(i + 1) % 4].seen || c.sides[(i + 3) % 4].seen))
      continue;
    end.by_face = true;
    end.sd_m = kFaceEndSd;
  }
  const auto extent = [&](const Side& a, const Side& b) {
    return SeenExtent{std::max(0.05, a.at_m - b.at_m), std::hypot(a.sd_m, b.sd_m),
                      (a.ended || a.by_face) && (b.ended || b.by_face)};
  };
  c.size = GuessSize({extent(c.sides[0], c.sides[2]), extent(c.sides[1], c.sides[3]),
                      SeenExtent{c.height_m, 0.07, true}},
                     regular);
  return c;
}

/// Moves the ends that were not seen to where the whole size has them.
void Complete(Candidate& c) {
  for (int axis = 0; axis < 2; ++axis) {
    Side& upper = c.sides[static_cast<std::size_t>(axis)];
    Side& lower = c.sides[static_cast<std::size_t>(axis) + 2];
    const double extent = upper.at_m - lower.at_m;
    if (upper.ended && lower.ended) continue;  // measured: no guess is better
    const double whole = std::max(extent, c.size.size_m[axis]);
    const double more = whole - extent, sd = std::max(0.05, c.size.sd_m[axis]);
    if (upper.ended) {
      lower.at_m -= more;
      lower.sd_m = sd;
    } else if (lower.ended) {
      upper.at_m += more;
      upper.sd_m = sd;
    } else {
      upper.at_m += more / 2.0;
      lower.at_m -= more / 2.0;
      upper.sd_m = lower.sd_m = std::hypot(sd, more / 2.0) / std::sqrt(2.0);
    }
  }
}

void FillCovariance(const Candidate& c, const BoxOptions& options, double heading_sd,
                    FittedBox& fitted) {
  const double pose2 = options.pose_sd_m * options.pose_sd_m;
  const auto var = [&](std::size_t side) { return c.sides[side].sd_m * c.sides[side].sd_m; };
  // Along forward and left: centre = (upper + lower) / 2, size = upper - lower.
  Eigen::Matrix<double, 7, 7> own = Eigen::Matrix<double, 7, 7>::Zero();
  for (int axis = 0; axis < 2; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const double upper = var(i), lower = var(i + 2);
    own(axis, axis) = (upper + lower) / 4.0 + pose2;
    own(3 + axis, 3 + axis) = upper + lower;
    own(axis, 3 + axis) = own(3 + axis, axis) = (upper - lower) / 2.0;
  }
  const double height2 = c.height_sd_m * c.height_sd_m;
  own(2, 2) = height2 / 4.0 + pose2;
  own(5, 5) = height2;
  own(2, 5) = own(5, 2) = height2 / 2.0;
  own(6, 6) = heading_sd * heading_sd + options.pose_heading_sd_rad * options.pose_heading_sd_rad;
  Eigen::Matrix<double, 7, 7> turn = Eigen::Matrix<double, 7, 7>::Identity();
  turn.block<2, 1>(0, 0) = Direction(c.heading_rad);
  turn.block<2, 1>(0, 1) = Direction(c.heading_rad - kQuarter);
  fitted.covariance = turn * own * turn.transpose();
}

}  // namespace

FittedBox FitBox(const ChangeRegion& region, double ground_m,
                 const std::function<double(const Eigen::Vector2d&)>& cut_m,
                 const BoxOptions& options) {
  const Points points(region, options);
  const Headings headings = SearchHeading(points, options);
  Candidate best = Measure(points, options, cut_m, headings.best_rad);
  // The same sides with length and width exchanged: what such things measure decides.
  Candidate turned = Measure(points, options, cut_m, headings.best_rad + kQuarter);
  std::optional<double> second = headings.second_rad;
  const auto evidence = [&](const Candidate& c) {
    return c.size.log_evidence + LogRoad(c.heading_rad, options);
  };
  if (evidence(turned) > evidence(best)) std::swap(best, turned);
  if (evidence(best) - evidence(turned) < kSecondHeading) second = turned.heading_rad;
  Complete(best);

  FittedBox fitted;
  // Of the two ends either may be the front: the one within a quarter turn of the road, or of
  // north, is.
  const double towards = options.road_heading_rad.value_or(0.0);
  double heading = Fold(best.heading_rad, 2.0 * core::kPi);
  bool reversed = false;
  if (std::abs(core::WrapPi(heading - towards)) > kQuarter) {
    heading = Fold(heading + core::kPi, 2.0 * core::kPi);
    reversed = true;
  }
  const Eigen::Vector2d forward = Direction(best.heading_rad),
                        left = Direction(best.heading_rad - kQuarter);
  const double along = (best.sides[0].at_m + best.sides[2].at_m) / 2.0;
  const double across = (best.sides[1].at_m + best.sides[3].at_m) / 2.0;
  const Eigen::Vector2d centre = points.centre + along * forward + across * left;
  const double height = std::max(best.height_m, 0.05);
  fitted.box.centre_m = {centre.x(), centre.y(), ground_m + height / 2.0};
  fitted.box.size_m = {best.sides[0].at_m - best.sides[2].at_m,
                       best.sides[1].at_m - best.sides[3].at_m, height};
  fitted.box.heading_rad = heading;
  for (std::size_t i = 0; i < 4; ++i)
    fitted.side_seen[i] = best.sides[reversed ? (i + 2) % 4 : i].seen;
  fitted.side_seen[4] = best.top_seen;
  // The covariance is that of centre and size: a half turn changes nothing.
  FillCovariance(best, options, headings.sd_rad, fitted);
  if (second) {
    double other = Fold(*second, core::kPi);
    if (std::abs(core::WrapPi(other - towards)) > kQuarter)
      other = Fold(other + core::kPi, 2.0 * core::kPi);
    fitted.second_heading_rad = other;
  }
  fitted.size = best.size;
  return fitted;
}

FittedBox FitBoxPaper(const ChangeRegion& region, double ground_m, double heading_rad) {
  const Eigen::Vector2d forward = Direction(heading_rad), left = Direction(heading_rad - kQuarter);
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low;
  for (const ChangePoint& p : region.points) {
    const Eigen::Vector3d at(p.position_m.head<2>().dot(forward), p.position_m.head<2>().dot(left),
                             p.position_m.z());
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
  }
  low.z() = ground_m;
  FittedBox fitted;
  const Eigen::Vector3d middle = (low + high) / 2.0;
  const Eigen::Vector2d centre = middle.x() * forward + middle.y() * left;
  fitted.box = {{centre.x(), centre.y(), middle.z()}, high - low, heading_rad};
  // The paper states 50 cm of its model and nothing of its boxes: half a voxel for every side, and
  // axes of the road as far as things stand along it.
  constexpr double kSideSd = 0.25, kHeadingSd = 0.1;
  Candidate candidate;
  candidate.heading_rad = heading_rad;
  for (Side& side : candidate.sides) side.sd_m = kSideSd;
  candidate.height_sd_m = kSideSd;
  FillCovariance(candidate, BoxOptions{}, kHeadingSd, fitted);
  fitted.side_seen.fill(true);
  fitted.size.probability = 0.0;
  fitted.size.size_m = fitted.box.size_m;
  return fitted;
}

}  // namespace kawara::vision
