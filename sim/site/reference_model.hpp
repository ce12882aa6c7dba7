#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "sim/site/site_config.hpp"
#include "sim/site/terrain.hpp"

/// The site as a city model knew it before the disaster: blocks of buildings with their roofs, and
/// the road. In the forms city models come in. Coordinates and errors as in truth_objects.hpp.
namespace kawara::sim {

enum class SurfaceRole { kGround, kWall, kRoof };

/// A building without openings, eaves and fittings: level of detail 2 of CityGML.
struct ReferenceBuilding {
  std::string name;
  std::vector<Eigen::Vector2d> footprint_enu_m;  ///< counter-clockwise
  double ground_m = 0.0;                         ///< lowest ground along the footprint, up in ENU
  double eaves_m = 0.0;                          ///< top of the walls
  double top_m = 0.0;                            ///< of the roof
  RoofType roof = RoofType::kFlat;
  int storeys = 1;
  struct Surface {
    SurfaceRole role;
    std::vector<Eigen::Vector3d> ring_enu_m;  ///< counter-clockwise from outside, not closed
  };
  std::vector<Surface> surfaces;  ///< a closed shell
};

/// Buildings of the state before, those that the disaster took included.
std::vector<ReferenceBuilding> ReferenceBuildings(const SiteConfig& site, const Terrain& terrain);

/// Edge of the asphalt (`with_pavement`: of the pavements), counter-clockwise, from the road's
/// first point to its last; heights from the terrain.
std::vector<Eigen::Vector3d> RoadPolygon(const SiteConfig& site, const Terrain& terrain,
                                         bool with_pavement);

/// CityJSON 1.1, Building objects with solids of lod 1.2 and 2.2. Reference system EPSG:4979 with
/// its own axis order (latitude, longitude, ellipsoidal height), as Japan's PLATEAU models have
/// theirs. Source: CityJSON specifications 1.1.3.
core::Expected<void> WriteReferenceCityJson(const SiteConfig& site, const Terrain& terrain,
                                            const std::string& path);

/// GeoJSON: the carriageway and the road with its pavements, two polygons.
core::Expected<void> WriteRoadGeoJson(const SiteConfig& site, const Terrain& terrain,
                                      const std::string& path);

/// Heights of the ground about the road above the ellipsoid [m], every 5e-6 degrees, as an ESRI
/// ASCII grid in WGS 84 with its .prj beside it.
core::Expected<void> WriteGroundGrid(const SiteConfig& site, const Terrain& terrain,
                                     const std::string& path);

}  // namespace kawara::sim
