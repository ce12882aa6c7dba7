#include "sim/site/road_line.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace kawara::sim {
namespace {

using Eigen::Vector2d;

Vector2d LeftOf(const Vector2d& way) { return {-way.y(), way.x()}; }

/// Collects stations; knows how far it has come.
class Walk {
 public:
  Walk(std::vector<RoadStation>& stations, double along_m)
      : stations_(stations), along_m_(along_m) {}
  void Stand(const Vector2d& at, const Vector2d& way) {
    stations_.push_back({at, LeftOf(way), along_m_});
  }
  void Line(const Vector2d& from, const Vector2d& to, double step_m) {
    const double length = (to - from).norm();
    if (length < 1e-6) return;
    const Vector2d way = (to - from) / length;
    const int steps = std::max(1, static_cast<int>(std::ceil(length / step_m - 1e-9)));
    const double start = along_m_;
    for (int i = 1; i <= steps; ++i) {
      along_m_ = start + length * i / steps;
      Stand(from + way * (length * i / steps), way);
    }
  }
  void Arc(const Vector2d& centre, const Vector2d& from, double turn_rad, double step_m) {
    const Vector2d spoke = from - centre;
    const double length = std::abs(turn_rad) * spoke.norm();
    const int steps = std::max(2, static_cast<int>(std::ceil(length / step_m)));
    const double start = along_m_;
    for (int i = 1; i <= steps; ++i) {
      const Vector2d turned = Eigen::Rotation2Dd(turn_rad * i / steps) * spoke;
      along_m_ = start + length * i / steps;
      const Vector2d way = LeftOf(turned.normalized()) * (turn_rad > 0 ? 1.0 : -1.0);
      Stand(centre + turned, way);
    }
  }

 private:
  std::vector<RoadStation>& stations_;
  double along_m_;
};

/// Doubling steps, so that the far ends cost little: distances from the road's end outwards.
std::vector<double> FarSteps(double step_m, double beyond_m) {
  std::vector<double> at;
  double step = 2.0 * step_m;
  for (double d = step; d < beyond_m; d += step, step = std::min(step * 1.5, 40.0)) at.push_back(d);
  at.push_back(beyond_m);
  return at;
}

}  // namespace

std::vector<RoadStation> RoadStations(const RoadConfig& road, double step_m, double beyond_m) {
  const std::vector<Vector2d> corners = ToVectors(road.points_m);
  std::vector<RoadStation> stations;
  const Vector2d first_way = (corners[1] - corners[0]).normalized();
  const std::vector<double> far = FarSteps(step_m, beyond_m);
  for (auto d = far.rbegin(); d != far.rend(); ++d)
    stations.push_back({corners[0] - first_way * *d, LeftOf(first_way), -*d});
  Walk walk(stations, 0.0);
  walk.Stand(corners[0], first_way);
  Vector2d at = corners[0];
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    const Vector2d in = (corners[i] - corners[i - 1]).normalized();
    const Vector2d out = (corners[i + 1] - corners[i]).normalized();
    const double turn = std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out));
    if (std::abs(turn) < 1e-4) continue;
    const double cut = road.corner_radius_m * std::tan(std::abs(turn) / 2.0);
    const Vector2d begin = corners[i] - in * cut;
    walk.Line(at, begin, step_m);
    const Vector2d centre = begin + LeftOf(in) * std::copysign(road.corner_radius_m, turn);
    walk.Arc(centre, begin, turn, step_m / 2.0);
    at = corners[i] + out * cut;
  }
  walk.Line(at, corners.back(), step_m);
  const Vector2d last_way = (corners.back() - corners[corners.size() - 2]).normalized();
  const double end = stations.back().along_m;
  for (double d : far)
    stations.push_back({corners.back() + last_way * d, LeftOf(last_way), end + d});
  return stations;
}

double RoadLength(const RoadConfig& road) {
  constexpr double kBeyond_m = 1.0;
  return RoadStations(road, 1.0, kBeyond_m).back().along_m - kBeyond_m;
}

}  // namespace kawara::sim
