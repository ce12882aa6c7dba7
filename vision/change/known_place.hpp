#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "vision/change/reference_map.hpp"
#include "vision/change/road_area.hpp"
#include "vision/change/road_axis.hpp"

namespace kawara::vision {

/// What was known of a place before the robot came: surfaces, ground and road of the reference.
/// Reading from any thread while nothing is written.
struct KnownPlace {
  ReferenceMap reference;
  RoadArea road;
  std::vector<RoadAxis> axes;  ///< middles of the road: the GIS's own, else those of its area

  /// Errors: kInvalidArgument: the reference has no road; those of RoadArea.
  static core::Expected<KnownPlace> Of(ReferenceMap reference);
  /// Errors: kInvalidArgument: the reference's origin is not the map's, to a millimetre.
  static core::Expected<void> CheckOrigin(const ReferenceMap& reference,
                                          const core::Geodetic& origin);
};

/// A disc of the map's plane.
struct PlaneDisc {
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
  double radius_m = 0.0;
  bool Contains(const Eigen::Vector2d& p) const { return (p - centre_m).norm() <= radius_m; }
};

}  // namespace kawara::vision
