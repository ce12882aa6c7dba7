#include <GeographicLib/UTMUPS.hpp>
#include <array>
#include <cmath>
#include <vector>

#include "core/iso8601.hpp"
#include "gis/kiwi/export_text.hpp"
#include "gis/kiwi/geodetic_box.hpp"
#include "gis/kiwi/object_elements.hpp"
#include "gis/kiwi/object_exports.hpp"
#include "gis/model/whole_file.hpp"

/// Source: CityJSON specifications 1.1.3: 2 (objects), 3.2 (Solid), 4 (transform), 5 (metadata).
namespace kawara::gis {
namespace {

constexpr double kStepM = 1e-4;

struct Projection {
  int zone = 0;
  bool north = true;
  Eigen::Vector3d Of(const core::Geodetic& g) const {
    int same_zone = zone;
    bool same_north = north;
    double x = 0.0, y = 0.0;
    GeographicLib::UTMUPS::Forward(g.lat_rad * core::kDegFromRad, g.lon_rad * core::kDegFromRad,
                                   same_zone, same_north, x, y, zone);
    // Across the equator a zone goes on in the origin's half.
    constexpr double kFalseNorthingM = 1e7;
    if (same_north != north) y += north ? -kFalseNorthingM : kFalseNorthingM;
    return {x, y, g.h_ellipsoidal_m};
  }
};

/// Corners of a box's faces, counter-clockwise from outside, as numbers of its apexes.
constexpr std::array<std::array<int, 4>, 6> kFaces{
    {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};

std::string Shell(std::size_t first_vertex) {
  std::string json;
  for (const auto& face : kFaces) {
    json += json.empty() ? "[[" : ",[[";
    for (std::size_t i = 0; i < face.size(); ++i)
      json += (i > 0 ? "," : "") + std::to_string(first_vertex + static_cast<std::size_t>(face[i]));
    json += "]]";
  }
  return "[" + json + "]";
}

std::string Triple(const Eigen::Vector3d& v, int decimals) {
  return "[" + Number(v.x(), decimals) + "," + Number(v.y(), decimals) + "," +
         Number(v.z(), decimals) + "]";
}

std::string CityObject(const core::ChangedObject& object, const core::LocalEnu& map,
                       std::size_t first_vertex) {
  const ElementSet elements = ElementsOf(object, map, object.first_seen);
  std::string dates = ",\"creationDate\":" + JsonString(core::FormatIso8601(object.first_seen));
  if (object.gone.IsSet())
    dates += ",\"terminationDate\":" + JsonString(core::FormatIso8601(object.gone));
  return JsonString(object.uid) + ":{\"type\":\"GenericCityObject\",\"attributes\":{" +
         JsonMembers(elements.attributes) + dates +
         "},\"geometry\":[{\"type\":\"Solid\",\"lod\":\"1\",\"boundaries\":[" +
         Shell(first_vertex) + "]}]}";
}

}  // namespace

core::Expected<void> WriteObjectsCityJson(const std::filesystem::path& path,
                                          const SurveyObjects& survey) {
  const core::LocalEnu map(survey.origin);
  const double lat_deg = survey.origin.lat_rad * core::kDegFromRad;
  Projection projection;
  projection.zone = GeographicLib::UTMUPS::StandardZone(
      lat_deg, survey.origin.lon_rad * core::kDegFromRad, GeographicLib::UTMUPS::STANDARD);
  projection.north = lat_deg >= 0.0;
  if (projection.zone < 1)
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      path.string() + ": CityJSON in UTM ends at the polar caps");

  std::vector<Eigen::Vector3d> vertices;
  std::string objects;
  for (const core::ChangedObject& object : survey.objects) {
    objects.append(objects.empty() ? "\n" : ",\n").append(CityObject(object, map, vertices.size()));
    for (const core::Geodetic& apex : GeodeticOf(object.box, map).apexes)
      vertices.push_back(projection.Of(apex));
  }
  Eigen::Vector3d low = projection.Of(survey.origin), high = low;
  if (!vertices.empty()) low = high = vertices.front();
  for (const Eigen::Vector3d& v : vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  low = (low.array() / kStepM).floor() * kStepM;
  std::string numbers;
  for (const Eigen::Vector3d& v : vertices)
    numbers.append(numbers.empty() ? "\n" : ",\n")
        .append(Triple(((v - low) / kStepM).array().round(), 0));

  const std::string epsg = std::to_string((projection.north ? 32600 : 32700) + projection.zone);
  const std::string step = Number(kStepM, 4);
  return WriteWholeFile(
      path, "{\"type\":\"CityJSON\",\"version\":\"1.1\",\"transform\":{\"scale\":[" + step + "," +
                step + "," + step + "],\"translate\":" + Triple(low, 4) +
                "},\"metadata\":{\"title\":" + JsonString("Changed objects, " + survey.survey) +
                ",\"referenceSystem\":\"https://www.opengis.net/def/crs/EPSG/0/" + epsg +
                "\",\"geographicalExtent\":[" + Number(low.x(), 4) + "," + Number(low.y(), 4) +
                "," + Number(low.z(), 4) + "," + Number(high.x(), 4) + "," + Number(high.y(), 4) +
                "," + Number(high.z(), 4) + "]},\"CityObjects\":{" + objects + "},\"vertices\":[" +
                numbers + "]}\n");
}

}  // namespace kawara::gis
