#pragma once
#include <optional>
#include <span>
#include <vector>

#include "core/changed_object.hpp"
#include "vision/change/change_points.hpp"

namespace kawara::vision {

struct WidthOptions {
  /// Widths that vehicles need, ascending [m]; a station's class is how many of them pass.
  std::vector<double> classes_m{2.5, 3.0, 4.0};
  /// Deviation of where the GIS has the road's edge.
  double edge_sd_m = 0.05;
  /// Of the ground between two things, so much must have been seen for the gap to count as free;
  /// what was not looked at is no road to send anybody through.
  double min_seen_share = 0.3;
  double most_width_m = 30.0;  ///< a square is cut there
  /// Of how the obstacles' map lies in the road's (Alignment), east and north: counts between an
  /// obstacle and an edge, not between two obstacles.
  Eigen::Matrix2d fit_covariance_m2 = Eigen::Matrix2d::Zero();
};

/// What stands on the road, for its width: its box, whose near sides lie where they were measured.
struct Obstacle {
  core::UprightBox box;
  double side_sd_m = 0.05;  ///< of the sides that face the road
  double end_sd_m = 0.0;    ///< of its ends along the road: the stations there may be blocked too
};

/// The road every RoadAxis::kStep along an axis: what of its width is left to pass. An obstacle
/// takes what its box takes within half a step to either side. Stations at which the axis is
/// outside of the road, or not `within`, are left out. Times and uids are not set.
std::vector<core::RoadStation> MeasureWidth(const RoadArea& road, const RoadAxis& axis,
                                            std::span<const Obstacle> obstacles,
                                            const ChangePoints& look, const WidthOptions& options,
                                            const std::optional<PlaneDisc>& within = {});

}  // namespace kawara::vision
