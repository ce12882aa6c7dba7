#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "gis/city/city_surfaces.hpp"

namespace kawara::gis {

using Triangle = std::array<Eigen::Vector3d, 3>;

/// Triangles that fill a plane surface with holes, any way up, wound as its outer ring is. A hole
/// is joined to the outer ring by a bridge (Eberly, "Triangulation by Ear Clipping", section 5),
/// then ears are cut. Rings that cross themselves give what fits and never hang; empty: no area.
std::vector<Triangle> Triangulate(const CitySurface& surface);

}  // namespace kawara::gis
