#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "vision/change/road_area.hpp"

namespace kawara::vision {

/// A line along the road with a point every step.
struct RoadAxis {
  static constexpr double kStep = 0.5;  ///< m: of the stations

  std::string name;
  std::vector<Eigen::Vector2d> points_m;

  /// Direction of the road at a point, from its neighbours; unit.
  Eigen::Vector2d TangentAt(std::size_t i) const;
};

/// A line through these points (a GIS's centre line, the robot's track), smoothed and with a point
/// every RoadAxis::kStep. Fewer than two different points: nothing.
std::optional<RoadAxis> AxisAlong(const std::string& name,
                                  const std::vector<Eigen::Vector2d>& points_m);

/// The middle lines of an area: the longest of its skeleton (thinning after Zhang and Suen, CACM
/// 1984) and branches of it that are longer than the road is wide, run on straight to the area's
/// ends.
std::vector<RoadAxis> AxesOf(const RoadArea& road);

/// The true heading of the nearest axis, clockwise from north, in [0, pi): a road has no front.
/// Nothing: no axis within 50 m.
std::optional<double> RoadHeadingAt(const std::vector<RoadAxis>& axes, const Eigen::Vector2d& p);

}  // namespace kawara::vision
