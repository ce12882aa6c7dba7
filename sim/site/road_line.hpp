#pragma once
#include <Eigen/Core>
#include <vector>

#include "sim/site/site_config.hpp"

namespace kawara::sim {

/// A place on the road's middle line.
struct RoadStation {
  Eigen::Vector2d middle_m;  ///< east, north
  Eigen::Vector2d left;      ///< unit, across the road
  double along_m = 0.0;      ///< from the road's first point; negative before it
};

/// The middle line of a road: its polyline with every corner replaced by an arc, drawn on straight
/// by `beyond_m` at both ends. Stations are at most `step_m` apart between the ends and on arcs,
/// wider apart beyond.
std::vector<RoadStation> RoadStations(const RoadConfig& road, double step_m, double beyond_m);

/// Along the middle line, from the first point to the last.
double RoadLength(const RoadConfig& road);

}  // namespace kawara::sim
