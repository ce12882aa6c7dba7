#include "gis/kiwi/change_overlay.hpp"

#include <ogrsf_frmts.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "gis/kiwi/class_colour.hpp"
#include "gis/kiwi/kiwi_schema.hpp"
#include "gis/ogr_dataset.hpp"

namespace kawara::gis {
namespace {

constexpr std::array kClasses{core::SizeClass::kTruck, core::SizeClass::kCar,
                              core::SizeClass::kRubble, core::SizeClass::kPerson,
                              core::SizeClass::kUnknown};

Colour ColourOf(const std::array<std::uint8_t, 3>& rgb) { return {rgb[0], rgb[1], rgb[2]}; }

core::Geodetic PlaceAt(const OGRFeature& row, int field) {
  return {row.GetFieldAsDouble(field + 1) * core::kRadFromDeg,
          row.GetFieldAsDouble(field) * core::kRadFromDeg, row.GetFieldAsDouble(field + 2)};
}

MapOverlay::Outline OutlineOf(const OGRFeature& row) {
  MapOverlay::Outline outline;
  for (int i = 0; i < 4; ++i) outline.ring.push_back(PlaceAt(row, 5 + 3 * i));
  const std::string cls = row.GetFieldAsString(1);
  outline.colour = ColourOf(ClassColour(core::SizeClass::kUnknown));
  for (const core::SizeClass one : kClasses)
    if (cls == core::ToString(one)) outline.colour = ColourOf(ClassColour(one));
  std::array<char, 160> label{};
  std::snprintf(label.data(), label.size(), "%s: %.1f x %.1f x %.1f m", cls.c_str(),
                row.GetFieldAsDouble(2), row.GetFieldAsDouble(3), row.GetFieldAsDouble(4));
  outline.label = label.data();
  return outline;
}

/// So that tracks and boxes stand out on it.
Colour Lighter(const Colour& c) {
  const auto half = [](std::uint8_t v) { return static_cast<std::uint8_t>((v + 255) / 2); };
  return {half(c.red), half(c.green), half(c.blue)};
}

void AddStation(const OGRFeature& row, MapOverlay& overlay) {
  core::RoadStation station;
  station.unknown_share = row.GetFieldAsDouble("unknown_share");
  station.passable_class = static_cast<std::uint32_t>(row.GetFieldAsInteger("passable_class"));
  const OGRGeometry* geometry = row.GetGeometryRef();
  const OGRLineString* line = geometry == nullptr ? nullptr : geometry->toLineString();
  if (line == nullptr || line->getNumPoints() < 2) return;
  // The gap only: what is left to pass.
  const int last = line->getNumPoints() - 1;
  const auto place = [&](double across_m) {
    const double share = across_m / std::max(0.01, row.GetFieldAsDouble("road_width_m"));
    const auto between = [&](double from, double to) { return from + share * (to - from); };
    return core::Geodetic{between(line->getY(0), line->getY(last)) * core::kRadFromDeg,
                          between(line->getX(0), line->getX(last)) * core::kRadFromDeg,
                          between(line->getZ(0), line->getZ(last))};
  };
  overlay.strokes.push_back({place(row.GetFieldAsDouble("gap_begin_m")),
                             place(row.GetFieldAsDouble("gap_end_m")),
                             Lighter(ColourOf(StationColour(station)))});
}

void AddLegend(MapOverlay& overlay) {
  core::RoadStation road;
  const auto add = [&](std::uint32_t cls, double unknown, const char* text) {
    road.passable_class = cls;
    road.unknown_share = unknown;
    overlay.legend.push_back({Lighter(ColourOf(StationColour(road))), text});
  };
  if (!overlay.strokes.empty()) {
    add(2, 0.0, "gap: wider vehicles pass");
    add(1, 0.0, "gap: the narrowest vehicle passes");
    add(0, 0.0, "gap: nothing passes for sure");
  }
  for (const core::SizeClass cls : kClasses)
    if (!overlay.outlines.empty())
      overlay.legend.push_back(
          {ColourOf(ClassColour(cls)), std::string("changed: ") + core::ToString(cls)});
}

}  // namespace

core::Expected<MapOverlay> LoadChangeOverlay(const std::string& store) {
  auto dataset = OgrDataset::Open(store, true);
  if (!dataset) return tl::unexpected(dataset.error());
  MapOverlay overlay;
  if (dataset->Layer(kChangedObject) == nullptr) return overlay;
  std::string apexes;
  for (const char* apex : {"apex0", "apex1", "apex2", "apex3"})
    apexes += std::string(", ") + apex + "_lon_deg, " + apex + "_lat_deg, " + apex + "_h_m";
  auto read =
      dataset->ForEach("SELECT id, class, length_m, width_m, height_m" + apexes + " FROM " +
                           kChangedObject + " WHERE end_ns IS NULL ORDER BY id",
                       [&](const OGRFeature& row) { overlay.outlines.push_back(OutlineOf(row)); });
  if (read)
    read = dataset->ForEach(
        std::string("SELECT * FROM ") + kRoadStation + " WHERE end_ns IS NULL ORDER BY id",
        [&](const OGRFeature& row) { AddStation(row, overlay); });
  if (!read) return tl::unexpected(read.error());
  AddLegend(overlay);
  return overlay;
}

}  // namespace kawara::gis
