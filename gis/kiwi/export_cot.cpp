#include <cmath>

#include "core/html.hpp"
#include "core/iso8601.hpp"
#include "gis/kiwi/class_colour.hpp"
#include "gis/kiwi/export_text.hpp"
#include "gis/kiwi/geodetic_box.hpp"
#include "gis/kiwi/object_elements.hpp"
#include "gis/kiwi/object_exports.hpp"

/// Source: MITRE, Cursor on Target event schema 2.0 (event, point, detail; hae above the ellipsoid,
/// ce and le as one standard deviation of a position).
namespace kawara::gis {
namespace {

/// A spot on the map somebody should know of; how: fused by a machine.
constexpr const char* kType = "b-m-p-s-m";
constexpr const char* kHow = "m-f";

std::string Named(const char* name, const std::string& value) {
  return std::string(" ") + name + "=\"" + core::HtmlEscaped(value) + "\"";
}

std::string PlaceOf(const core::Geodetic& g) {
  return Named("lat", Latitude(g)) + Named("lon", Longitude(g)) + Named("hae", Height(g));
}

std::string Remarks(const core::ChangedObject& o) {
  return std::string(core::ToString(o.size_class)) + " " + Number(o.box.size_m.x(), 2) + " x " +
         Number(o.box.size_m.y(), 2) + " x " + Number(o.box.size_m.z(), 2) + " m, " +
         core::ToString(o.state) + ", existence " + Number(o.existence_probability, 2);
}

/// Signed 32 bits of alpha, red, green, blue, as TAK writes colours.
std::string Argb(const std::array<std::uint8_t, 3>& rgb) {
  const std::uint32_t argb = 0xFF000000U | static_cast<std::uint32_t>(rgb[0]) << 16U |
                             static_cast<std::uint32_t>(rgb[1]) << 8U | rgb[2];
  return std::to_string(static_cast<std::int32_t>(argb));
}

}  // namespace

std::string CursorOnTargetEvent(const core::ChangedObject& object, const core::Geodetic& origin,
                                core::UtcTime sent, core::UtcTime stale) {
  const core::LocalEnu map(origin);
  const GeodeticBox box = GeodeticOf(object.box, map);
  const core::Geodetic floor =
      map.ToGeodetic(object.box.centre_m - Eigen::Vector3d(0.0, 0.0, object.box.size_m.z() / 2.0));
  const double ce_m = std::sqrt((object.covariance(0, 0) + object.covariance(1, 1)) / 2.0);
  const double le_m = std::sqrt(object.covariance(2, 2));
  const core::UtcTime end = object.gone.IsSet() ? object.gone : stale;
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"yes\"?>\n<event";
  xml += Named("version", "2.0") + Named("uid", object.uid) + Named("type", kType) +
         Named("how", kHow) + Named("time", core::FormatIso8601(sent)) +
         Named("start", core::FormatIso8601(object.first_seen)) +
         Named("stale", core::FormatIso8601(end)) + ">\n  <point" + PlaceOf(floor) +
         Named("ce", Number(ce_m, 3)) + Named("le", Number(le_m, 3)) + "/>\n  <detail>\n";
  xml += "    <contact" + Named("callsign", object.uid) + "/>\n    <remarks>" +
         core::HtmlEscaped(Remarks(object)) + "</remarks>\n    <color" +
         Named("argb", Argb(ClassColour(object.size_class))) + "/>\n";
  xml += "    <shape><polyline" + Named("closed", "true") + ">";
  for (std::size_t i = 0; i < 4; ++i) xml += "<vertex" + PlaceOf(box.apexes[i]) + "/>";
  xml += "</polyline></shape>\n    <kawaraban_box" +
         Named("revision", std::to_string(object.revision)) +
         Named("state", core::ToString(object.state)) + ">";
  for (const core::Geodetic& apex : box.apexes) xml += "<apex" + PlaceOf(apex) + "/>";
  xml += "\n";
  for (const Attribute& a : ElementsOf(object, map, object.first_seen).attributes)
    xml += "      <attribute" + Named("key", a.key) + Named("value", a.value) +
           Named("unit", a.unit) + "/>\n";
  return xml + "    </kawaraban_box>\n  </detail>\n</event>\n";
}

}  // namespace kawara::gis
