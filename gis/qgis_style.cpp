#include <array>
#include <sstream>
#include <string>

#include "gis/rtk_colour.hpp"
#include "gis/schema.hpp"
#include "gis/store_schema.hpp"

/// Styles in QGIS's own XML as version 3.22 saves and reads it (newer versions read it too).
namespace kawara::gis {
namespace {

struct Symbol {
  const char* type;   ///< "marker", "line"
  const char* value;  ///< the attribute's value that gets it
  std::string layer;  ///< XML of its symbol layer
};

std::string Options(const std::vector<std::pair<std::string, std::string>>& options) {
  std::string xml = "<Option type=\"Map\">";
  for (const auto& [name, value] : options)
    xml.append("<Option type=\"QString\" name=\"")
        .append(name)
        .append("\" value=\"")
        .append(value)
        .append("\"/>");
  return xml + "</Option>";
}

/// A marker turned by an expression (degrees clockwise from north), empty: not turned.
std::string Marker(const char* shape, const std::string& rgb, const char* size_mm,
                   const std::string& angle) {
  std::string xml = "<layer class=\"SimpleMarker\" locked=\"0\" enabled=\"1\" pass=\"0\">" +
                    Options({{"name", shape},
                             {"color", rgb + ",255"},
                             {"outline_color", "35,35,35,255"},
                             {"outline_width", "0.2"},
                             {"outline_width_unit", "MM"},
                             {"size", size_mm},
                             {"size_unit", "MM"}});
  if (!angle.empty())
    xml +=
        "<data_defined_properties><Option type=\"Map\">"
        "<Option type=\"QString\" name=\"name\" value=\"\"/>"
        "<Option type=\"Map\" name=\"properties\"><Option type=\"Map\" name=\"angle\">"
        "<Option type=\"bool\" name=\"active\" value=\"true\"/>"
        "<Option type=\"QString\" name=\"expression\" value=\"" +
        angle +
        "\"/><Option type=\"int\" name=\"type\" value=\"3\"/></Option></Option>"
        "<Option type=\"QString\" name=\"type\" value=\"collection\"/>"
        "</Option></data_defined_properties>";
  return xml + "</layer>";
}

std::string Line(const std::string& rgb, const char* width_mm) {
  return "<layer class=\"SimpleLine\" locked=\"0\" enabled=\"1\" pass=\"0\">" +
         Options({{"line_color", rgb + ",255"},
                  {"line_width", width_mm},
                  {"line_width_unit", "MM"},
                  {"joinstyle", "round"},
                  {"capstyle", "round"}}) +
         "</layer>";
}

std::string Categorized(const char* attribute, const std::vector<Symbol>& symbols) {
  std::ostringstream xml;
  xml << "<renderer-v2 type=\"categorizedSymbol\" attr=\"" << attribute
      << "\" symbollevels=\"0\" enableorderby=\"0\" forceraster=\"0\"><categories>";
  for (std::size_t i = 0; i < symbols.size(); ++i)
    xml << "<category symbol=\"" << i << "\" value=\"" << symbols[i].value << "\" label=\""
        << symbols[i].value << "\" render=\"true\"/>";
  xml << "</categories><symbols>";
  for (std::size_t i = 0; i < symbols.size(); ++i)
    xml << "<symbol type=\"" << symbols[i].type << "\" name=\"" << i
        << "\" alpha=\"1\" clip_to_extent=\"1\">" << symbols[i].layer << "</symbol>";
  xml << "</symbols></renderer-v2>";
  return xml.str();
}

std::string Single(const Symbol& symbol) {
  return std::string(
             "<renderer-v2 type=\"singleSymbol\" symbollevels=\"0\"><symbols><symbol type=\"") +
         symbol.type + "\" name=\"0\" alpha=\"1\" clip_to_extent=\"1\">" + symbol.layer +
         "</symbol></symbols></renderer-v2>";
}

std::string Rgb(const Colour& c) {
  return std::to_string(c.red) + "," + std::to_string(c.green) + "," + std::to_string(c.blue);
}

std::string PoseRenderer() {
  std::vector<Symbol> symbols;
  symbols.reserve(kRtkColours.size());
  for (const RtkColour& c : kRtkColours)
    symbols.push_back({"marker", core::ToString(c.state),
                       Marker("arrow", Rgb(c.colour), "6", "&quot;yaw_deg&quot;")});
  return Categorized("rtk_state", symbols);
}

std::string PanoramaRenderer() {
  return Categorized("stage", {{"marker", "full", Marker("circle", "49,54,149", "3", "")},
                               {"marker", "preview", Marker("circle", "171,217,233", "3", "")}});
}

/// Hovering over a picture's point shows the picture.
constexpr const char* kPanoramaTip =
    "<mapTip>&lt;img width=\"640\" src=\"file://[% regexp_replace(layer_property(@layer_id, "
    "'source'), "
    "'[^/]*$', '') || &quot;uri&quot; %]\"/>&lt;br/>[% &quot;robot&quot; %] [% &quot;epoch&quot; "
    "%]</mapTip>";

}  // namespace

namespace {

// Mode 2: start and end fields. Mode 1: one field and a duration, here a second for an event.
std::string Qml(bool event, const std::string& symbology) {
  return std::string(
             "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n"
             "<qgis version=\"3.22\" styleCategories=\"Symbology|MapTips|Temporal\">"
             "<temporal enabled=\"1\" mode=\"") +
         (event ? "1" : "2") + "\" startField=\"t_begin\" endField=\"" + (event ? "" : "t_end") +
         "\" limitMode=\"0\" accumulate=\"0\" durationField=\"\" durationUnit=\"s\" "
         "fixedDuration=\"" +
         (event ? "1" : "0") +
         "\" startExpression=\"\" "
         "endExpression=\"\"><fixedRange><start></start><end></end></fixedRange>"
         "</temporal>" +
         symbology + "</qgis>\n";
}

}  // namespace

std::string QmlWithTime(const std::string& symbology) { return Qml(false, symbology); }

std::string QmlStyle(const std::string& layer) {
  std::string body;
  if (layer == kObsPose) body = PoseRenderer();
  if (layer == kObsPanorama) body = PanoramaRenderer() + kPanoramaTip;
  if (layer == kTrajectory) body = Single({"line", "", Line("69,117,180", "0.6")});
  return Qml(layer == kEventLog, body);
}

}  // namespace kawara::gis
