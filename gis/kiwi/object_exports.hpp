#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/changed_object.hpp"
#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "core/object_textures.hpp"
#include "core/textured_mesh.hpp"

/// What changed, in the files other programs take: each its own small one, whole or not written at
/// all (whole_file.hpp gives the errors), the same objects the same bytes. The eight apexes are in
/// every one of them to the millimetre.
namespace kawara::gis {

/// A survey's findings: the newest revision of each object, in the plane at `origin`.
struct SurveyObjects {
  core::Geodetic origin;
  std::string survey;
  std::vector<core::ChangedObject> objects = {};
  std::vector<core::RoadStation> stations = {};
  std::map<std::string, core::ObjectTextures> textures = {};  ///< by uid
};

/// GeoJSON (RFC 7946): a feature an object (outline of its floor) and one a station (line across
/// the road); heights above the ellipsoid; properties hold every figure and the apexes as lists of
/// [longitude, latitude, height].
core::Expected<void> WriteObjectsGeoJson(const std::filesystem::path& path,
                                         const SurveyObjects& survey);

/// KMZ (OGC KML 2.3 in a ZIP): a placemark an object with its TimeSpan, standing on the viewer's
/// ground as an extruded box, with its picture in the balloon; road stations as lines coloured by
/// what passes. Apexes with ellipsoidal heights are in the extended data.
core::Expected<void> WriteObjectsKmz(const std::filesystem::path& path,
                                     const SurveyObjects& survey);

/// CityJSON 1.1: a GenericCityObject with a Solid an object, in WGS 84 / UTM of the origin's zone
/// (so that metric tools measure it), heights above the ellipsoid. Not within the polar caps
/// (kInvalidArgument).
core::Expected<void> WriteObjectsCityJson(const std::filesystem::path& path,
                                          const SurveyObjects& survey);

/// One Cursor-on-Target 2.0 event for one object: a marker at the middle of its floor, uid as in
/// the register, ce and le one standard deviation, outline and apexes in the detail. It goes stale
/// at `stale`; an object that is gone went stale when it was gone.
std::string CursorOnTargetEvent(const core::ChangedObject& object, const core::Geodetic& origin,
                                core::UtcTime sent, core::UtcTime stale);

/// The boxes as meshes for WriteVrml and WriteGlb: front, left, rear, right and top, the sides that
/// have a texture in one mesh with the atlas, the others in one of the class's colour.
std::vector<core::TexturedMesh> BoxMeshes(const SurveyObjects& survey);

}  // namespace kawara::gis
