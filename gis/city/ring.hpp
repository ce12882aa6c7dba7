#pragma once
#include <Eigen/Core>
#include <vector>

namespace kawara::gis {

/// Area of a ring seen from above [m^2], positive if counter-clockwise.
double PlanArea(const std::vector<Eigen::Vector3d>& ring_m);

/// Drops the repeated first corner and every corner equal to the one before it; false: fewer than
/// three are left, or one is not finite.
bool CleanRing(std::vector<Eigen::Vector3d>& ring_m);

}  // namespace kawara::gis
