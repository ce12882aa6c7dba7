#pragma once
#include <string>

#include "core/expected.hpp"
#include "sim/site/scene.hpp"
#include "sim/site/site_config.hpp"
#include "sim/site/terrain.hpp"

namespace kawara::sim {

/// A site for QGIS and other programs, one GeoPackage with the layers
///   objects              boxes of the things of a scene (six faces each), class, existence
///   reference_buildings  footprints on the ground with heights, as the GIS knew them
///   reference_roads      carriageway; road with its pavements
/// Errors: those of gis::WritePolygonFile.
core::Expected<void> WriteTruthGeoPackage(const Scene& scene, const SiteConfig& site,
                                          const Terrain& terrain, const std::string& path);

}  // namespace kawara::sim
