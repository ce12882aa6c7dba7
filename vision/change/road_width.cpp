#include "vision/change/road_width.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace kawara::vision {
namespace {

constexpr double kProbe = 0.125;  // m between looks at the ground

/// What something takes of the road's width, across the axis from its left edge.
struct Taken {
  double begin_m = 0.0, end_m = 0.0, sd_m = 0.0;
};

struct Section {
  Eigen::Vector2d at, tangent, left;  ///< unit; across = left * offset
  double to_left_m = 0.0, to_right_m = 0.0;
  double width_m() const { return to_left_m + to_right_m; }
  /// From the left edge.
  double Across(const Eigen::Vector2d& p) const { return to_left_m - (p - at).dot(left); }
  double Along(const Eigen::Vector2d& p) const { return (p - at).dot(tangent); }
  Eigen::Vector2d PointAt(double across_m) const { return at + (to_left_m - across_m) * left; }
};

/// How far the road goes in a direction, to a centimetre.
double ToEdge(const RoadArea& road, const Eigen::Vector2d& from, const Eigen::Vector2d& direction,
              double most_m) {
  double inside = 0.0;
  const int probes = static_cast<int>(most_m / kProbe);
  for (int i = 1; i <= probes; ++i) {
    const double next = i * kProbe;
    if (!road.Contains(from + next * direction)) {
      double low = inside, high = next;
      while (high - low > 0.005) {
        const double middle = (low + high) / 2.0;
        (road.Contains(from + middle * direction) ? low : high) = middle;
      }
      return (low + high) / 2.0;
    }
    inside = next;
  }
  return inside;
}

/// The part of a convex footprint that lies within `half` along the axis, as an interval across.
bool Clip(const core::UprightBox& box, const Section& section, double half, Taken& taken) {
  const auto apexes = box.Apexes();
  std::vector<Eigen::Vector2d> ring;  // along, across
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d p = apexes[i].head<2>();
    ring.emplace_back(section.Along(p), section.Across(p));
  }
  bool any = false;
  const auto add = [&](double across) {
    taken.begin_m = any ? std::min(taken.begin_m, across) : across;
    taken.end_m = any ? std::max(taken.end_m, across) : across;
    any = true;
  };
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d &a = ring[i], &b = ring[(i + 1) % ring.size()];
    if (std::abs(a.x()) <= half) add(a.y());
    for (const double cut : {-half, half})
      if ((a.x() < cut) != (b.x() < cut))
        add(a.y() + (cut - a.x()) / (b.x() - a.x()) * (b.y() - a.y()));
  }
  return any;
}

std::vector<Taken> TakenAt(const Section& section, std::span<const Obstacle> obstacles) {
  constexpr double kHalf = RoadAxis::kStep / 2.0, kMostEnd = 0.5;
  std::vector<Taken> all;
  for (const Obstacle& obstacle : obstacles) {
    const double half = kHalf + 2.0 * std::min(obstacle.end_sd_m, kMostEnd);
    const double reach = obstacle.box.size_m.head<2>().norm() / 2.0 + half;
    if (std::abs(section.Along(obstacle.box.centre_m.head<2>())) > reach) continue;
    Taken taken{0.0, 0.0, obstacle.side_sd_m};
    if (!Clip(obstacle.box, section, half, taken)) continue;
    taken.begin_m = std::max(taken.begin_m, 0.0);
    taken.end_m = std::min(taken.end_m, section.width_m());
    if (taken.end_m > taken.begin_m) all.push_back(taken);
  }
  std::sort(all.begin(), all.end(),
            [](const Taken& a, const Taken& b) { return a.begin_m < b.begin_m; });
  return all;
}

class GapSearch {
 public:
  GapSearch(const Section& section, const ChangePoints& look, const WidthOptions& options)
      : section_(section), look_(look), options_(options) {}

  void Consider(double begin_m, double begin_sd, double end_m, double end_sd,
                core::RoadStation& station) const {
    const double width = end_m - begin_m;
    if (width <= station.passable_m || Seen(begin_m, end_m) < options_.min_seen_share) return;
    station.passable_m = width;
    station.passable_sd_m = std::hypot(begin_sd, end_sd);
    station.gap_begin_m = begin_m;
    station.gap_end_m = end_m;
  }
  /// Share of the ground that was seen.
  double Seen(double begin_m, double end_m) const {
    int all = 0, seen = 0;
    const int probes = static_cast<int>(std::ceil((end_m - begin_m) / kProbe - 0.5));
    for (int i = 0; i < probes; ++i) {
      const double across = begin_m + (i + 0.5) * kProbe;
      ++all;
      // The square beside counts as well: votes do not hit every one.
      const Eigen::Vector2d p = section_.PointAt(across);
      const Eigen::Vector2d aside = ChangePoints::kGroundCell * section_.tangent;
      if (look_.GroundSeen(p) || look_.GroundSeen(p + aside) || look_.GroundSeen(p - aside)) ++seen;
    }
    return all == 0 ? 0.0 : static_cast<double>(seen) / all;
  }

 private:
  const Section& section_;
  const ChangePoints& look_;
  const WidthOptions& options_;
};

core::RoadStation StationAt(const Section& section, std::span<const Obstacle> obstacles,
                            const ChangePoints& look, const WidthOptions& options) {
  core::RoadStation station;
  station.left_m.head<2>() = section.PointAt(0.0);
  station.right_m.head<2>() = section.PointAt(section.width_m());
  station.road_width_m = section.width_m();
  const GapSearch gaps(section, look, options);
  const double fit_sd = std::sqrt(section.left.dot(options.fit_covariance_m2 * section.left));
  double free_from = 0.0, from_sd = options.edge_sd_m, unknown = 0.0;
  bool from_edge = true;
  const auto close_gap = [&](double at, double sd, bool to_edge) {
    if (at <= free_from) return;
    const double apart_sd = from_edge == to_edge ? 0.0 : fit_sd;
    gaps.Consider(free_from, std::hypot(from_sd, apart_sd), at, sd, station);
    unknown += (1.0 - gaps.Seen(free_from, at)) * (at - free_from);
  };
  for (const Taken& taken : TakenAt(section, obstacles)) {
    close_gap(taken.begin_m, taken.sd_m, false);
    if (taken.end_m > free_from) {
      free_from = taken.end_m;
      from_sd = taken.sd_m;
      from_edge = false;
    }
  }
  close_gap(section.width_m(), options.edge_sd_m, true);
  station.unknown_share = std::clamp(unknown / std::max(0.01, section.width_m()), 0.0, 1.0);
  for (const double need : options.classes_m)
    if (station.passable_m - 2.0 * station.passable_sd_m >= need) ++station.passable_class;
  return station;
}

}  // namespace

std::vector<core::RoadStation> MeasureWidth(const RoadArea& road, const RoadAxis& axis,
                                            std::span<const Obstacle> obstacles,
                                            const ChangePoints& look, const WidthOptions& options,
                                            const std::optional<PlaneDisc>& within) {
  std::vector<core::RoadStation> stations;
  for (std::size_t i = 0; i < axis.points_m.size(); ++i) {
    Section section;
    section.at = axis.points_m[i];
    if (within && !within->Contains(section.at)) continue;
    section.tangent = axis.TangentAt(i);
    section.left = {-section.tangent.y(), section.tangent.x()};
    if (!road.Contains(section.at)) continue;
    section.to_left_m = ToEdge(road, section.at, section.left, options.most_width_m);
    section.to_right_m = ToEdge(road, section.at, -section.left, options.most_width_m);
    core::RoadStation station = StationAt(section, obstacles, look, options);
    station.road = axis.name;
    station.along_m = static_cast<double>(i) * RoadAxis::kStep;
    stations.push_back(std::move(station));
  }
  return stations;
}

}  // namespace kawara::vision
