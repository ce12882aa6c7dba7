#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "core/expected.hpp"
#include "sim/vehicle/smooth_series.hpp"
#include "sim/vehicle/vehicle_config.hpp"

namespace kawara::sim {

/// The line over the ground that the turning point follows, seen from above: waypoints joined by
/// straights and rounded corners, in legs. Between two legs the vehicle stands and turns on the
/// spot (skid-steer only). The argument everywhere is the way: metres along the raw line from the
/// start; in corners the smoothed line is a percent or so shorter. Immutable.
class GroundPath {
 public:
  /// Errors: kInvalidArgument, naming the waypoint.
  static core::Expected<GroundPath> Make(const VehicleConfig& vehicle, const PathConfig& path);

  /// Position, and its derivatives by the way; heading (clockwise from north) too.
  struct Point {
    Eigen::Vector2d position_m, d1, d2;
    double heading_rad = 0.0, heading_d1 = 0.0, heading_d2 = 0.0;
    double turned_before_rad = 0.0;  ///< sum of the turns on the spot up to this leg
  };
  Point At(double way_m) const;
  double length_m() const { return length_m_; }
  double SpeedAt(double way_m) const;  ///< wished

  struct Stop {
    double way_m = 0.0;
    double stand_s = 0.0;
    double turn_rad = 0.0;  ///< on the spot, clockwise
  };
  /// In order of way; the ends of the path are none.
  const std::vector<Stop>& stops() const { return stops_; }

 private:
  struct Leg {
    double begin_m, length_m;
    double turned_before_rad;
    SmoothSeries east, north;  ///< with kPad values before the begin and after the end
  };
  struct SpeedChange {
    double way_m, speed_mps;
  };
  class Builder;
  std::vector<Leg> legs_;
  std::vector<Stop> stops_;
  std::vector<SpeedChange> speeds_;
  double length_m_ = 0.0;
};

}  // namespace kawara::sim
