#pragma once
#include <filesystem>

#include "core/expected.hpp"
#include "sim/world/site_world.hpp"

namespace kawara::sim {

/// Writes what is true of a simulated world into a folder that exists: the files of
/// WriteDriveTruth, and
///   truth_camera.csv       gps_ns,lat_deg,lon_deg,h_ellipsoidal_m,roll_deg,pitch_deg,yaw_deg: the
///                          camera's viewpoint, 100 a second; attitude is the body's
///   truth_objects.csv      what stands at the site after the disaster, as boxes with eight apexes,
///                          and when (see WriteObjectsCsv)
///   truth_new_objects.csv  those of them that the reference does not know
///   truth.gpkg             objects, reference buildings and roads for QGIS
///   reference_city.json, reference_road.geojson, reference_ground.asc: the place before, as a GIS
///                          knew it, for kawara-reference
///   site.yaml, robot.yaml  as resolved; reading them again gives the same world
/// Errors: kIo with the file's name.
core::Expected<void> WriteWorldTruth(const SiteWorld& world, const std::filesystem::path& folder);

}  // namespace kawara::sim
