#pragma once
#include <array>

#include "core/changed_object.hpp"
#include "core/geodesy.hpp"

namespace kawara::gis {

/// A box as a GIS wants it, whatever map it was found in.
struct GeodeticBox {
  std::array<core::Geodetic, 8> apexes;  ///< UprightBox::Apexes' order
  core::Geodetic centre;
  double heading_rad = 0.0;  ///< against true north at its own centre, not at the map's origin
};

GeodeticBox GeodeticOf(const core::UprightBox& box, const core::LocalEnu& map);

/// The inverse: back into a map, which may have another origin.
core::UprightBox BoxFrom(const core::Geodetic& centre, const Eigen::Vector3d& size_m,
                         double heading_rad, const core::LocalEnu& map);

/// The same object in another map: what a robot reports in the plane at its own origin. Box and
/// second heading turn; the covariance stays (maps a kilometre apart differ by 0.2 mrad).
core::ChangedObject InMap(const core::ChangedObject& object, const core::LocalEnu& from,
                          const core::LocalEnu& to);

/// By how much [rad, clockwise] true north at `place` points past the map's own north.
double NorthAt(const core::Geodetic& place, const core::LocalEnu& map);

}  // namespace kawara::gis
