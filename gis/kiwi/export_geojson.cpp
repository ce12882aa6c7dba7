#include "core/iso8601.hpp"
#include "gis/kiwi/export_text.hpp"
#include "gis/kiwi/geodetic_box.hpp"
#include "gis/kiwi/object_elements.hpp"
#include "gis/kiwi/object_exports.hpp"
#include "gis/model/whole_file.hpp"

namespace kawara::gis {
namespace {

std::string Position(const core::Geodetic& g) {
  return "[" + Longitude(g) + "," + Latitude(g) + "," + Height(g) + "]";
}

std::string TimeOrNull(core::UtcTime t) {
  return t.IsSet() ? JsonString(core::FormatIso8601(t)) : "null";
}

std::string Feature(const std::string& id, const std::string& geometry,
                    const std::string& properties) {
  return "{\"type\":\"Feature\",\"id\":" + JsonString(id) + ",\"geometry\":" + geometry +
         ",\"properties\":{" + properties + "}}";
}

std::string FeatureOf(const core::ChangedObject& object, const core::LocalEnu& map) {
  const GeodeticBox box = GeodeticOf(object.box, map);
  std::string ring, apexes;
  for (std::size_t i = 0; i <= 4; ++i)
    ring.append(i > 0 ? "," : "").append(Position(box.apexes[i % 4]));
  for (std::size_t i = 0; i < box.apexes.size(); ++i)
    apexes.append(i > 0 ? "," : "").append(Position(box.apexes[i]));
  const ElementSet elements = ElementsOf(object, map, object.first_seen);
  return Feature(object.uid, "{\"type\":\"Polygon\",\"coordinates\":[[" + ring + "]]}",
                 "\"class_code\":" + JsonString(kClassBox) + ",\"t_begin\":" +
                     TimeOrNull(object.first_seen) + ",\"t_end\":" + TimeOrNull(object.gone) + "," +
                     JsonMembers(elements.attributes) + ",\"apexes\":[" + apexes + "]");
}

std::string FeatureOf(const core::RoadStation& station, const core::LocalEnu& map) {
  const ElementSet elements = ElementsOf(station, map, station.observed);
  return Feature(
      StationUid(station),
      "{\"type\":\"LineString\",\"coordinates\":[" + Position(map.ToGeodetic(station.left_m)) +
          "," + Position(map.ToGeodetic(station.right_m)) + "]}",
      "\"class_code\":" + JsonString(elements.connector.class_code) + ",\"t_begin\":" +
          TimeOrNull(station.observed) + ",\"t_end\":null," + JsonMembers(elements.attributes));
}

}  // namespace

core::Expected<void> WriteObjectsGeoJson(const std::filesystem::path& path,
                                         const SurveyObjects& survey) {
  const core::LocalEnu map(survey.origin);
  std::string json =
      "{\"type\":\"FeatureCollection\",\"survey\":" + JsonString(survey.survey) + ",\"features\":[";
  bool first = true;
  const auto add = [&](const std::string& feature) {
    json.append(first ? "\n" : ",\n").append(feature);
    first = false;
  };
  for (const core::ChangedObject& object : survey.objects) add(FeatureOf(object, map));
  for (const core::RoadStation& station : survey.stations) add(FeatureOf(station, map));
  return WriteWholeFile(path, json + "\n]}\n");
}

}  // namespace kawara::gis
