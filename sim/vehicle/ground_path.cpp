#include "sim/vehicle/ground_path.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "core/geodesy.hpp"

namespace kawara::sim {
namespace {

constexpr double kClosest_m = 0.05;
constexpr double kStraight_rad = 1e-3;
/// Sharper corners than these are turned on the spot, or refused.
constexpr double kSharpest_rad = 150.0 * core::kRadFromDeg;
constexpr double kSmallestRadius_m = 0.1;
/// Smoothing makes arcs tighter by about a percent; see kSamplesPerRadius.
constexpr double kRadiusReserve = 1.04;
constexpr double kSamplesPerRadius = 5.0;
constexpr int kPad = 3;

Eigen::Vector2d Ahead(double heading_rad) { return {std::sin(heading_rad), std::cos(heading_rad)}; }

/// A straight (curvature 0) or an arc; positive curvature turns clockwise.
struct Piece {
  Eigen::Vector2d from_m;
  double heading_rad, curvature_1pm, length_m;

  Eigen::Vector2d At(double way_m) const {
    const Eigen::Vector2d ahead = Ahead(heading_rad);
    if (curvature_1pm == 0.0) return from_m + way_m * ahead;
    const Eigen::Vector2d right(ahead.y(), -ahead.x());
    const double angle = way_m * curvature_1pm;
    return from_m + (std::sin(angle) * ahead + (1.0 - std::cos(angle)) * right) / curvature_1pm;
  }
};

/// What happens at a waypoint in the middle of the path.
struct Corner {
  double turn_rad = 0.0;
  double radius_m = 0.0;  ///< 0: none (straight on, or turned on the spot)
  bool on_the_spot = false;
  double cut_m = 0.0;  ///< of the way before and after the waypoint that the arc replaces
};

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

}  // namespace

class GroundPath::Builder {
 public:
  Builder(const VehicleConfig& vehicle, const PathConfig& path)
      : vehicle_(vehicle), points_(path.waypoints), speed_mps_(path.speed_mps) {}

  core::Expected<GroundPath> Build() {
    if (points_.size() < 2)
      return core::Fail(core::ErrorCode::kInvalidArgument, "path: needs two waypoints or more");
    for (std::size_t i = 0; i + 1 < points_.size(); ++i) {
      const Eigen::Vector2d way = Place(i + 1) - Place(i);
      if (way.norm() < kClosest_m) {
        return core::Fail(core::ErrorCode::kInvalidArgument,
                          Name(i + 1) + ": less than 5 cm from the one before it; leave one out");
      }
      lengths_m_.push_back(way.norm());
      headings_rad_.push_back(std::atan2(way.x(), way.y()));
    }
    corners_.assign(points_.size(), {});
    for (std::size_t i = 1; i + 1 < points_.size(); ++i)
      corners_[i].turn_rad = core::WrapPi(headings_rad_[i] - headings_rad_[i - 1]);
    for (std::size_t i = 1; i + 1 < points_.size(); ++i) {
      core::Expected<void> decided = Decide(i);
      if (!decided) return tl::unexpected(decided.error());
    }
    path_.speeds_.push_back({0.0, points_[0].speed_mps.value_or(speed_mps_)});
    std::size_t first = 0;
    for (std::size_t i = 1; i < points_.size(); ++i) {
      if (i + 1 < points_.size() && !corners_[i].on_the_spot) continue;
      AddLeg(first, i);
      first = i;
    }
    return std::move(path_);
  }

 private:
  Eigen::Vector2d Place(std::size_t i) const { return {points_[i].east_m, points_[i].north_m}; }
  static std::string Name(std::size_t i) { return "path.waypoints[" + std::to_string(i) + "]"; }
  bool Straight(std::size_t i) const { return std::abs(corners_[i].turn_rad) < kStraight_rad; }

  /// How the corner at waypoint i is taken.
  core::Expected<void> Decide(std::size_t i) {
    Corner& corner = corners_[i];
    if (Straight(i)) return {};
    const bool skid = vehicle_.kind == VehicleKind::kSkidSteer;
    const double half_tan = std::tan(std::abs(corner.turn_rad) / 2.0);
    // Half of each way, as the next corner wants its half; all of it at the path's ends.
    const double room_m = std::min(lengths_m_[i - 1] * (i > 1 ? 0.5 : 0.98),
                                   lengths_m_[i] * (i + 2 < points_.size() ? 0.5 : 0.98));
    const double least_m =
        std::max(kSmallestRadius_m, kRadiusReserve * vehicle_.min_turning_radius_m);
    const double radius_m =
        std::min(std::max(vehicle_.corner_radius_m, least_m), room_m / half_tan);
    const bool fits = radius_m >= least_m && std::abs(corner.turn_rad) <= kSharpest_rad;
    if (skid && (points_[i].stop_s > 0.0 || !fits)) {
      corner.on_the_spot = true;
      return {};
    }
    if (!fits) {
      return core::Fail(core::ErrorCode::kInvalidArgument,
                        Name(i) + ": a turn by " +
                            Number(std::abs(corner.turn_rad) * core::kDegFromRad) +
                            " degrees at the turning radius of " + Number(least_m) + " m needs " +
                            Number(least_m * half_tan) + " m of way on both sides, has " +
                            Number(room_m) + "; move it, or take the turn in two");
    }
    corner.radius_m = radius_m;
    corner.cut_m = radius_m * half_tan;
    return {};
  }

  /// The leg from waypoint `first` to waypoint `last`.
  void AddLeg(std::size_t first, std::size_t last) {
    std::vector<Piece> pieces;
    double way_m = path_.length_m_;
    double tightest_m = 1.25;  // gives a pitch of 25 cm
    for (std::size_t i = first; i < last; ++i) {
      const double begin_cut_m = i > first ? corners_[i].cut_m : 0.0;
      const double end_cut_m = i + 1 < last ? corners_[i + 1].cut_m : 0.0;
      const double heading = headings_rad_[i];
      pieces.push_back({Place(i) + begin_cut_m * Ahead(heading), heading, 0.0,
                        lengths_m_[i] - begin_cut_m - end_cut_m});
      way_m += pieces.back().length_m;
      if (i + 1 == last) break;
      const Corner& corner = corners_[i + 1];
      double arc_m = 0.0;
      if (corner.radius_m > 0.0) {
        arc_m = corner.radius_m * std::abs(corner.turn_rad);
        pieces.push_back({pieces.back().At(pieces.back().length_m), heading,
                          std::copysign(1.0 / corner.radius_m, corner.turn_rad), arc_m});
        tightest_m = std::min(tightest_m, corner.radius_m);
      }
      Pass(i + 1, way_m + arc_m / 2.0, 0.0);
      way_m += arc_m;
    }
    const double length_m = way_m - path_.length_m_;
    const double turned = turned_rad_;
    if (last + 1 < points_.size()) {
      Pass(last, way_m, corners_[last].turn_rad);
      turned_rad_ += corners_[last].turn_rad;
    }
    const double pitch_m = PitchFor(length_m, tightest_m);
    const std::vector<Eigen::Vector2d> raw = Sample(pieces, length_m, pitch_m);
    std::vector<double> east, north;
    for (const Eigen::Vector2d& p : raw) {
      east.push_back(p.x());
      north.push_back(p.y());
    }
    path_.legs_.push_back({path_.length_m_, length_m, turned,
                           SmoothSeries(std::move(east), pitch_m),
                           SmoothSeries(std::move(north), pitch_m)});
    path_.length_m_ = way_m;
  }

  static double PitchFor(double length_m, double tightest_m) {
    return length_m / std::ceil(length_m * kSamplesPerRadius / tightest_m);
  }

  /// Waypoint i is passed at this way: its wishes begin to hold.
  void Pass(std::size_t i, double way_m, double turn_rad) {
    if (points_[i].stop_s > 0.0 || turn_rad != 0.0)
      path_.stops_.push_back({way_m, points_[i].stop_s, turn_rad});
    if (points_[i].speed_mps) path_.speeds_.push_back({way_m, *points_[i].speed_mps});
  }

  /// Points every pitch, straight on beyond both ends, so that the spline keeps the ends.
  static std::vector<Eigen::Vector2d> Sample(const std::vector<Piece>& pieces, double length_m,
                                             double pitch_m) {
    const int steps = static_cast<int>(std::lround(length_m / pitch_m));
    std::vector<Eigen::Vector2d> points;
    std::size_t piece = 0;
    double piece_begin_m = 0.0;
    for (int k = -kPad; k <= steps + kPad; ++k) {
      const double way_m = k * pitch_m;
      while (piece + 1 < pieces.size() && way_m > piece_begin_m + pieces[piece].length_m) {
        piece_begin_m += pieces[piece].length_m;
        ++piece;
      }
      points.push_back(pieces[piece].At(way_m - piece_begin_m));
    }
    return points;
  }

  const VehicleConfig& vehicle_;
  const std::vector<Waypoint>& points_;
  const double speed_mps_;
  std::vector<double> lengths_m_, headings_rad_;  ///< from waypoint i to the next
  std::vector<Corner> corners_;
  double turned_rad_ = 0.0;
  GroundPath path_;
};

core::Expected<GroundPath> GroundPath::Make(const VehicleConfig& vehicle, const PathConfig& path) {
  return Builder(vehicle, path).Build();
}

GroundPath::Point GroundPath::At(double way_m) const {
  const auto after =
      std::upper_bound(legs_.begin(), legs_.end(), way_m,
                       [](double value, const Leg& leg) { return value < leg.begin_m; });
  const Leg& leg = *(after == legs_.begin() ? after : after - 1);
  const double argument =
      std::clamp(way_m - leg.begin_m, 0.0, leg.length_m) + kPad * leg.east.pitch();
  const SmoothSeries::Jet e = leg.east.At(argument);
  const SmoothSeries::Jet n = leg.north.At(argument);
  Point point;
  point.position_m = {e[0], n[0]};
  point.d1 = {e[1], n[1]};
  point.d2 = {e[2], n[2]};
  point.heading_rad = std::atan2(e[1], n[1]);
  const double square = e[1] * e[1] + n[1] * n[1];
  const double turn = e[2] * n[1] - n[2] * e[1];
  point.heading_d1 = turn / square;
  point.heading_d2 = (e[3] * n[1] - n[3] * e[1]) / square -
                     2.0 * turn * (e[1] * e[2] + n[1] * n[2]) / (square * square);
  point.turned_before_rad = leg.turned_before_rad;
  return point;
}

double GroundPath::SpeedAt(double way_m) const {
  const auto after = std::upper_bound(
      speeds_.begin(), speeds_.end(), way_m,
      [](double value, const SpeedChange& change) { return value < change.way_m; });
  return (after == speeds_.begin() ? after : after - 1)->speed_mps;
}

}  // namespace kawara::sim
