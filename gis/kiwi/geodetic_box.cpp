#include "gis/kiwi/geodetic_box.hpp"

#include <cmath>

namespace kawara::gis {

double NorthAt(const core::Geodetic& place, const core::LocalEnu& map) {
  const Eigen::Vector3d north = core::RotationEnuFromNed(map.origin(), place).col(0);
  return std::atan2(north.x(), north.y());
}

GeodeticBox GeodeticOf(const core::UprightBox& box, const core::LocalEnu& map) {
  GeodeticBox geodetic;
  const auto apexes = box.Apexes();
  for (std::size_t i = 0; i < apexes.size(); ++i) geodetic.apexes[i] = map.ToGeodetic(apexes[i]);
  geodetic.centre = map.ToGeodetic(box.centre_m);
  geodetic.heading_rad = box.heading_rad - NorthAt(geodetic.centre, map);
  return geodetic;
}

core::UprightBox BoxFrom(const core::Geodetic& centre, const Eigen::Vector3d& size_m,
                         double heading_rad, const core::LocalEnu& map) {
  return {.centre_m = map.FromGeodetic(centre),
          .size_m = size_m,
          .heading_rad = heading_rad + NorthAt(centre, map)};
}

core::ChangedObject InMap(const core::ChangedObject& object, const core::LocalEnu& from,
                          const core::LocalEnu& to) {
  const GeodeticBox box = GeodeticOf(object.box, from);
  core::ChangedObject moved = object;
  moved.box = BoxFrom(box.centre, object.box.size_m, box.heading_rad, to);
  if (object.second_heading_rad)
    moved.second_heading_rad =
        *object.second_heading_rad - NorthAt(box.centre, from) + NorthAt(box.centre, to);
  return moved;
}

}  // namespace kawara::gis
