#include <array>
#include <string>

#include "gis/kiwi/class_colour.hpp"
#include "gis/kiwi/kiwi_schema.hpp"
#include "gis/store_schema.hpp"

/// How QGIS shows the register: boxes coloured by class, the road by what passes.
namespace kawara::gis {
namespace {

std::string Option(const std::string& name, const std::string& value) {
  return "<Option type=\"QString\" name=\"" + name + "\" value=\"" + value + "\"/>";
}

std::string Fill(const std::string& rgb) {
  return "<layer class=\"SimpleFill\" locked=\"0\" enabled=\"1\" pass=\"0\"><Option type=\"Map\">" +
         Option("color", rgb + ",150") + Option("outline_color", rgb + ",255") +
         Option("outline_width", "0.6") + Option("outline_width_unit", "MM") +
         Option("style", "solid") + "</Option></layer>";
}

std::string Line(const std::string& rgb) {
  return "<layer class=\"SimpleLine\" locked=\"0\" enabled=\"1\" pass=\"0\"><Option type=\"Map\">" +
         Option("line_color", rgb + ",255") + Option("line_width", "0.5") +
         Option("line_width_unit", "MM") + Option("capstyle", "flat") + "</Option></layer>";
}

std::string Symbol(const char* type, std::size_t number, const std::string& layer) {
  return std::string("<symbol type=\"") + type + "\" name=\"" + std::to_string(number) +
         "\" alpha=\"1\" clip_to_extent=\"1\">" + layer + "</symbol>";
}

constexpr std::array<core::SizeClass, 5> kClasses{
    core::SizeClass::kTruck, core::SizeClass::kCar, core::SizeClass::kRubble,
    core::SizeClass::kPerson, core::SizeClass::kUnknown};

std::string Rgb(const std::array<std::uint8_t, 3>& rgb) {
  return std::to_string(rgb[0]) + "," + std::to_string(rgb[1]) + "," + std::to_string(rgb[2]);
}

core::RoadStation StationWith(double unknown_share, std::uint32_t passable_class) {
  core::RoadStation station;
  station.unknown_share = unknown_share;
  station.passable_class = passable_class;
  return station;
}

std::string ObjectRenderer() {
  std::string categories, symbols;
  for (std::size_t i = 0; i < kClasses.size(); ++i) {
    const std::string name = core::ToString(kClasses[i]);
    categories += "<category symbol=\"" + std::to_string(i) + "\" value=\"" + name + "\" label=\"" +
                  name + "\" render=\"true\"/>";
    symbols += Symbol("fill", i, Fill(Rgb(ClassColour(kClasses[i]))));
  }
  return "<renderer-v2 type=\"categorizedSymbol\" attr=\"class\" symbollevels=\"0\" "
         "enableorderby=\"0\" forceraster=\"0\"><categories>" +
         categories + "</categories><symbols>" + symbols + "</symbols></renderer-v2>";
}

/// Hovering over a box shows its textures and figures.
constexpr const char* kObjectTip =
    "<mapTip>&lt;b>[% &quot;id&quot; %]&lt;/b> [% &quot;class&quot; %], revision [% "
    "&quot;revision&quot; %], [% round(&quot;length_m&quot;, 2) %] x [% "
    "round(&quot;width_m&quot;, 2) %] x [% round(&quot;height_m&quot;, 2) %] m&lt;br/>"
    "&lt;img width=\"320\" src=\"file://[% regexp_replace(layer_property(@layer_id, 'source'), "
    "'[^/]*$', '') || coalesce(&quot;texture_uri&quot;, '') %]\"/></mapTip>";

/// Blocked, narrow, wide: by the number of asked-for vehicle widths that pass; grey where more than
/// half of the road was not looked at.
std::string StationRenderer() {
  struct Rule {
    const char* filter;
    const char* label;
    core::RoadStation example;
  };
  const std::array<Rule, 4> kinds{{
      {"&quot;unknown_share&quot; > 0.5", "not looked at", StationWith(1, 0)},
      {"&quot;unknown_share&quot; &lt;= 0.5 AND &quot;passable_class&quot; = 0", "nothing passes",
       StationWith(0, 0)},
      {"&quot;unknown_share&quot; &lt;= 0.5 AND &quot;passable_class&quot; = 1", "narrow",
       StationWith(0, 1)},
      {"&quot;unknown_share&quot; &lt;= 0.5 AND &quot;passable_class&quot; > 1", "wide",
       StationWith(0, 2)},
  }};
  std::string rules, symbols;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const std::string number = std::to_string(i);
    rules += "<rule key=\"{r" + number + "}\" symbol=\"" + number + "\" filter=\"" +
             kinds[i].filter + "\" label=\"" + kinds[i].label + "\"/>";
    symbols += Symbol("line", i, Line(Rgb(StationColour(kinds[i].example))));
  }
  return "<renderer-v2 type=\"RuleRenderer\" symbollevels=\"0\" enableorderby=\"0\" "
         "forceraster=\"0\"><rules key=\"{root}\">" +
         rules + "</rules><symbols>" + symbols + "</symbols></renderer-v2>";
}

}  // namespace

std::string KiwiStyle(const std::string& layer) {
  if (layer == kChangedObject) return QmlWithTime(ObjectRenderer() + kObjectTip);
  if (layer == kRoadStation) return QmlWithTime(StationRenderer());
  if (layer == kVectorTable || layer == kConnectorTable || layer == kBoxTable ||
      layer == kModelTable)
    return QmlWithTime("");
  return {};
}

}  // namespace kawara::gis
