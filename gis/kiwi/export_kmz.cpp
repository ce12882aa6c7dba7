#include <array>
#include <cstdio>

#include "core/html.hpp"
#include "core/iso8601.hpp"
#include "gis/kiwi/class_colour.hpp"
#include "gis/kiwi/export_text.hpp"
#include "gis/kiwi/geodetic_box.hpp"
#include "gis/kiwi/object_elements.hpp"
#include "gis/kiwi/object_exports.hpp"
#include "gis/kiwi/zip_archive.hpp"
#include "gis/model/whole_file.hpp"

/// Source: OGC 12-007r2 (KML 2.3): 9.11 Placemark, 10.8 Polygon (extrude), 9.20 altitudeMode, 15.2
/// TimeSpan, 9.2 ExtendedData.
namespace kawara::gis {
namespace {

using core::HtmlEscaped;

/// aabbggrr.
std::string KmlColour(const std::array<std::uint8_t, 3>& rgb, unsigned alpha) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%02x%02x%02x%02x", alpha, unsigned{rgb[2]},
                unsigned{rgb[1]}, unsigned{rgb[0]});
  return text.data();
}

std::string Style(const std::array<std::uint8_t, 3>& rgb) {
  constexpr unsigned kHalf = 0x90, kOpaque = 0xff;
  return "<Style><LineStyle><color>" + KmlColour(rgb, kOpaque) +
         "</color><width>3</width></LineStyle><PolyStyle><color>" + KmlColour(rgb, kHalf) +
         "</color></PolyStyle></Style>";
}

std::string TimeSpan(core::UtcTime begin, core::UtcTime end) {
  if (!begin.IsSet()) return {};
  std::string kml = "<TimeSpan><begin>" + core::FormatIso8601(begin) + "</begin>";
  if (end.IsSet()) kml += "<end>" + core::FormatIso8601(end) + "</end>";
  return kml + "</TimeSpan>";
}

std::string Data(const std::string& name, const std::string& value) {
  return "<Data name=\"" + HtmlEscaped(name) + "\"><value>" + HtmlEscaped(value) +
         "</value></Data>";
}

std::string ExtendedData(const std::vector<Attribute>& attributes, const std::string& more) {
  std::string kml = "<ExtendedData>";
  std::string robots;
  for (const Attribute& a : attributes) {
    if (a.key == "robot") {
      robots.append(robots.empty() ? "" : ",").append(a.value);
    } else {
      kml += Data(a.unit.empty() || a.unit == "1" ? a.key : a.key + "_" + a.unit, a.value);
    }
  }
  if (!robots.empty()) kml += Data("robots", robots);
  return kml + more + "</ExtendedData>";
}

std::string Apexes(const GeodeticBox& box) {
  std::string text;
  for (const core::Geodetic& apex : box.apexes)
    text.append(text.empty() ? "" : " ")
        .append(Longitude(apex) + "," + Latitude(apex) + "," + Height(apex));
  return text;
}

std::string Balloon(const core::ChangedObject& o, const std::string& picture) {
  std::string html;
  if (!picture.empty()) html += "<img width=\"480\" src=\"" + HtmlEscaped(picture) + "\"/><br/>";
  html += std::string(core::ToString(o.size_class)) + ", " + Number(o.box.size_m.x(), 2) + " x " +
          Number(o.box.size_m.y(), 2) + " x " + Number(o.box.size_m.z(), 2) + " m, " +
          core::ToString(o.state) + ", existence " + Number(o.existence_probability, 2);
  return "<description>" + HtmlEscaped(html) + "</description>";
}

std::string PlacemarkOf(const core::ChangedObject& object, const core::LocalEnu& map,
                        const std::string& picture) {
  const GeodeticBox box = GeodeticOf(object.box, map);
  // KML knows heights over the geoid or the ground, ours are over the ellipsoid: the box stands on
  // the viewer's ground.
  std::string ring;
  for (std::size_t i = 0; i <= 4; ++i) {
    const core::Geodetic& top = box.apexes[4 + i % 4];
    ring.append(i > 0 ? " " : "")
        .append(Longitude(top) + "," + Latitude(top) + "," +
                Number(object.box.size_m.z(), kHeightDecimals));
  }
  const ElementSet elements = ElementsOf(object, map, object.first_seen);
  return "<Placemark id=\"" + HtmlEscaped("object." + object.uid) + "\"><name>" +
         HtmlEscaped(object.uid) + "</name>" + Balloon(object, picture) +
         TimeSpan(object.first_seen, object.gone) + Style(ClassColour(object.size_class)) +
         ExtendedData(elements.attributes, Data("apexes", Apexes(box))) +
         "<Polygon><extrude>1</extrude><altitudeMode>relativeToGround</altitudeMode>"
         "<outerBoundaryIs><LinearRing><coordinates>" +
         ring + "</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark>\n";
}

std::string PlacemarkOf(const core::RoadStation& station, const core::LocalEnu& map) {
  const core::Geodetic left = map.ToGeodetic(station.left_m);
  const core::Geodetic right = map.ToGeodetic(station.right_m);
  const ElementSet elements = ElementsOf(station, map, station.observed);
  return "<Placemark><name>" + Number(station.passable_m, 2) + " m at " +
         Number(station.along_m, 1) + " m</name>" + TimeSpan(station.observed, {}) +
         Style(StationColour(station)) + ExtendedData(elements.attributes, "") +
         "<LineString><altitudeMode>clampToGround</altitudeMode><coordinates>" + Longitude(left) +
         "," + Latitude(left) + " " + Longitude(right) + "," + Latitude(right) +
         "</coordinates></LineString></Placemark>\n";
}

std::string Folder(const std::string& name, const std::string& placemarks) {
  return "<Folder><name>" + name + "</name>\n" + placemarks + "</Folder>\n";
}

}  // namespace

core::Expected<void> WriteObjectsKmz(const std::filesystem::path& path,
                                     const SurveyObjects& survey) {
  const core::LocalEnu map(survey.origin);
  std::string objects, stations;
  std::vector<std::pair<std::string, const core::ObjectTextures*>> pictures;
  for (const core::ChangedObject& object : survey.objects) {
    std::string picture;
    if (const auto found = survey.textures.find(object.uid);
        found != survey.textures.end() && !found->second.atlas_jpeg.empty()) {
      picture = "textures/" + object.uid + ".jpg";
      pictures.emplace_back(picture, &found->second);
    }
    objects += PlacemarkOf(object, map, picture);
  }
  for (const core::RoadStation& station : survey.stations) stations += PlacemarkOf(station, map);
  std::string kml =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document><name>" +
      HtmlEscaped("Changed objects, " + survey.survey) + "</name>\n" +
      Folder("Changed objects", objects);
  if (!stations.empty()) kml += Folder("Road left to pass", stations);
  kml += "</Document>\n</kml>\n";

  // A viewer takes the first .kml of the archive.
  ZipArchive zip;
  auto done = zip.Add("doc.kml", kml);
  for (const auto& [name, textures] : pictures) {
    const std::string_view jpeg(reinterpret_cast<const char*>(textures->atlas_jpeg.data()),
                                textures->atlas_jpeg.size());
    if (done) done = zip.Add(name, jpeg);
  }
  return done ? WriteWholeFile(path, zip.Finish()) : done;
}

}  // namespace kawara::gis
