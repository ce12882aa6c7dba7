#pragma once
#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "sim/site/scene.hpp"

/// What stands at a site as the evaluator and a GIS read it. Geographic coordinates are WGS 84,
/// longitude before latitude in degrees with ten decimals (0.01 mm), heights above the ellipsoid
/// [m] with four. Files are written beside their place and renamed; errors: kIo, kPermission,
/// kNotFound.
namespace kawara::sim {

/// Corners of a box in ENU [m]: 0 to 3 the floor (front left, rear left, rear right, front right:
/// counter-clockwise from above; front is where the heading points), 4 to 7 the top above them.
std::array<Eigen::Vector3d, 8> Apexes(const UprightBox& box);

/// The part of an object's box above the ground: what results are compared with.
UprightBox VisibleBox(const SceneObject& object);

/// "building", "pole", ...: as in the files.
const char* NameOf(ObjectClass cls);

/// The objects of a scene that stand on the ground: all but the ground itself and the kerbs.
std::vector<SceneObject> StandingObjects(const Scene& scene);

/// Boxes are VisibleBox(). One line an object: id,name,class,in_reference,begin_s,end_s (empty:
/// open end), centre and size, heading, then apex0_lon_deg,apex0_lat_deg,apex0_h_m ... apex7_h_m.
/// The first line names the columns.
core::Expected<void> WriteObjectsCsv(const Scene& scene, const std::string& path);

/// The same as GeoJSON (RFC 7946): footprints with base, height and the rest as properties.
core::Expected<void> WriteObjectsGeoJson(const Scene& scene, const std::string& path);

}  // namespace kawara::sim
