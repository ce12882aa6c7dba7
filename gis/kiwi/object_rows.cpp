#include "gis/kiwi/object_rows.hpp"

#include <ogr_geometry.h>

#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <sstream>

#include "gis/kiwi/geodetic_box.hpp"
#include "gis/kiwi/kiwi_schema.hpp"
#include "gis/kiwi/object_elements.hpp"
#include "gis/kiwi/row_fields.hpp"

namespace kawara::gis {
namespace {

constexpr int kParameters = core::ChangedObject::kParameters;

double Deg(double rad) { return rad * core::kDegFromRad; }

std::string Shortest(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), end.ptr};
}

std::string Joined(const std::vector<std::string>& parts) {
  std::string all;
  for (const std::string& part : parts) all.append(all.empty() ? "" : ",").append(part);
  return all;
}

/// The box's floor; its heights as they are.
std::unique_ptr<OGRPolygon> FloorOf(const GeodeticBox& box) {
  auto ring = std::make_unique<OGRLinearRing>();
  for (std::size_t i = 0; i <= 4; ++i) {
    const core::Geodetic& apex = box.apexes[i % 4];
    ring->addPoint(Deg(apex.lon_rad), Deg(apex.lat_rad), apex.h_ellipsoidal_m);
  }
  auto polygon = std::make_unique<OGRPolygon>();
  polygon->addRingDirectly(ring.release());
  return polygon;
}

/// The columns that changed_object and kp_box share.
void FillFigures(OGRFeature& f, const core::ChangedObject& object, const GeodeticBox& box,
                 core::UtcTime begin) {
  SetInteger(f, "revision", static_cast<std::int64_t>(object.revision));
  SetTime(f, "t_begin", begin);
  SetTime(f, "first_seen", object.first_seen);
  SetTime(f, "last_seen", object.last_seen);
  SetReal(f, "centre_lon_deg", Deg(box.centre.lon_rad));
  SetReal(f, "centre_lat_deg", Deg(box.centre.lat_rad));
  SetReal(f, "centre_h_m", box.centre.h_ellipsoidal_m);
  SetReal(f, "length_m", object.box.size_m.x());
  SetReal(f, "width_m", object.box.size_m.y());
  SetReal(f, "height_m", object.box.size_m.z());
  SetReal(f, "heading_deg", Deg(box.heading_rad));
  constexpr std::array<const char*, 6> kSds{"sd_east_m",   "sd_north_m", "sd_up_m",
                                            "sd_length_m", "sd_width_m", "sd_height_m"};
  for (std::size_t i = 0; i < kSds.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    SetReal(f, kSds[i], std::sqrt(object.covariance(k, k)));
  }
  SetReal(f, "sd_heading_deg", Deg(std::sqrt(object.covariance(6, 6))));
  for (std::size_t i = 0; i < box.apexes.size(); ++i) {
    const std::string apex = "apex" + std::to_string(i);
    SetReal(f, (apex + "_lon_deg").c_str(), Deg(box.apexes[i].lon_rad));
    SetReal(f, (apex + "_lat_deg").c_str(), Deg(box.apexes[i].lat_rad));
    SetReal(f, (apex + "_h_m").c_str(), box.apexes[i].h_ellipsoidal_m);
  }
}

std::string CovarianceText(const core::ChangedObject& object) {
  std::string text;
  for (int row = 0; row < kParameters; ++row) {
    for (int column = row; column < kParameters; ++column)
      text.append(text.empty() ? "" : " ").append(Shortest(object.covariance(row, column)));
  }
  return text;
}

bool ReadCovariance(const std::string& text, core::ChangedObject& object) {
  const char* at = text.data();
  const char* const end = at + text.size();
  for (int row = 0; row < kParameters; ++row) {
    for (int column = row; column < kParameters; ++column) {
      double value = 0.0;
      const auto [next, error] = std::from_chars(at, end, value);
      if (error != std::errc()) return false;
      object.covariance(row, column) = object.covariance(column, row) = value;
      at = next + (next != end ? 1 : 0);
    }
  }
  return at == end;
}

/// The value of an enumeration that prints as `text`, among the first `count`.
template <class Enum>
bool ReadEnum(const std::string& text, int count, Enum& value) {
  for (int i = 0; i < count; ++i) {
    value = static_cast<Enum>(i);
    if (text == core::ToString(value)) return true;
  }
  return false;
}

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, separator);) parts.push_back(part);
  return parts;
}

}  // namespace

void FillObject(OGRFeature& f, const core::ChangedObject& object, const core::LocalEnu& map,
                const RowFrame& frame) {
  const GeodeticBox box = GeodeticOf(object.box, map);
  SetTextAlways(f, "id", object.uid);
  SetTextAlways(f, "class", core::ToString(object.size_class));
  SetReal(f, "class_probability", object.class_probability);
  SetTextAlways(f, "state", core::ToString(object.state));
  SetReal(f, "existence_probability", object.existence_probability);
  SetTextAlways(f, "survey", frame.survey);
  SetTextAlways(f, "robots", Joined(object.robots));
  FillFigures(f, object, box, frame.begin);
  if (object.second_heading_rad)
    SetReal(f, "second_heading_deg", Deg(*object.second_heading_rad - NorthAt(box.centre, map)));
  SetTextAlways(f, "sides_seen", SidesSeen(object));
  SetInteger(f, "voxels", object.voxels);
  SetInteger(f, "votes", static_cast<std::int64_t>(object.votes));
  SetText(f, "texture_uri", frame.texture_uri);
  SetTime(f, "last_absent", object.last_absent);
  SetTextAlways(f, "outline_id", frame.outline_id);
  SetTextAlways(f, "covariance", CovarianceText(object));
  SetNs(f, "begin_ns", frame.begin);
  SetNs(f, "last_absent_ns", object.last_absent);
  SetNs(f, "first_seen_ns", object.first_seen);
  SetNs(f, "last_seen_ns", object.last_seen);
  SetNs(f, "gone_ns", object.gone);
  auto geometry = std::make_unique<OGRMultiPolygon>();
  geometry->addGeometryDirectly(FloorOf(box).release());
  f.SetGeometryDirectly(geometry.release());
}

void FillBox(OGRFeature& f, const core::ChangedObject& object, const core::LocalEnu& map,
             const RowFrame& frame) {
  const GeodeticBox box = GeodeticOf(object.box, map);
  SetTextAlways(f, "object_uid", object.uid);
  FillFigures(f, object, box, frame.begin);
  SetText(f, "evidence", frame.evidence);
  f.SetGeometryDirectly(FloorOf(box).release());
}

void FillStation(OGRFeature& f, const core::RoadStation& station, const core::LocalEnu& map,
                 const RowFrame& frame, const std::string& element_id) {
  SetTextAlways(f, "id", StationUid(station));
  SetTextAlways(f, "road", station.road);
  SetTextAlways(f, "survey", frame.survey);
  SetReal(f, "along_m", station.along_m);
  SetTime(f, "t_begin", frame.begin);
  SetReal(f, "road_width_m", station.road_width_m);
  SetReal(f, "passable_m", station.passable_m);
  SetReal(f, "passable_sd_m", station.passable_sd_m);
  SetReal(f, "gap_begin_m", station.gap_begin_m);
  SetReal(f, "gap_end_m", station.gap_end_m);
  SetReal(f, "unknown_share", station.unknown_share);
  SetInteger(f, "passable_class", station.passable_class);
  SetTime(f, "observed", station.observed);
  SetNs(f, "begin_ns", frame.begin);
  SetNs(f, "observed_ns", station.observed);
  SetTextAlways(f, "element_id", element_id);
  auto line = std::make_unique<OGRLineString>();
  for (const Eigen::Vector3d& edge : {station.left_m, station.right_m}) {
    const core::Geodetic g = map.ToGeodetic(edge);
    line->addPoint(Deg(g.lon_rad), Deg(g.lat_rad), g.h_ellipsoidal_m);
  }
  f.SetGeometryDirectly(line.release());
}

core::Expected<core::ChangedObject> ReadObject(const OGRFeature& row, const core::LocalEnu& map) {
  core::ChangedObject object;
  object.uid = row.GetFieldAsString("id");
  const auto spoiled = [&object](const char* column) {
    return core::Fail(core::ErrorCode::kFormat, std::string(kChangedObject) + ": " + object.uid +
                                                    ": " + column + " is not what was written");
  };
  object.revision = static_cast<std::uint64_t>(row.GetFieldAsInteger64("revision"));
  if (!ReadEnum(row.GetFieldAsString("state"), 5, object.state)) return spoiled("state");
  if (!ReadEnum(row.GetFieldAsString("class"), 5, object.size_class)) return spoiled("class");
  const auto real = [&row](const char* name) { return row.GetFieldAsDouble(name); };
  const core::Geodetic centre{real("centre_lat_deg") * core::kRadFromDeg,
                              real("centre_lon_deg") * core::kRadFromDeg, real("centre_h_m")};
  object.box = BoxFrom(centre, {real("length_m"), real("width_m"), real("height_m")},
                       real("heading_deg") * core::kRadFromDeg, map);
  if (!ReadCovariance(row.GetFieldAsString("covariance"), object)) return spoiled("covariance");
  for (const std::string& name : Split(row.GetFieldAsString("sides_seen"), ' ')) {
    core::BoxSide side{};
    if (!ReadEnum(name, static_cast<int>(core::kBoxSides), side)) return spoiled("sides_seen");
    object.side_seen[static_cast<std::size_t>(side)] = true;
  }
  if (!IsNull(row, "second_heading_deg"))
    object.second_heading_rad =
        real("second_heading_deg") * core::kRadFromDeg + NorthAt(centre, map);
  object.existence_probability = real("existence_probability");
  object.class_probability = real("class_probability");
  object.voxels = static_cast<std::uint32_t>(row.GetFieldAsInteger64("voxels"));
  object.votes = static_cast<std::uint64_t>(row.GetFieldAsInteger64("votes"));
  object.last_absent = GetNs(row, "last_absent_ns");
  object.first_seen = GetNs(row, "first_seen_ns");
  object.last_seen = GetNs(row, "last_seen_ns");
  object.gone = GetNs(row, "gone_ns");
  object.robots = Split(row.GetFieldAsString("robots"), ',');
  return object;
}

}  // namespace kawara::gis
