#include "gis/kiwi/object_elements.hpp"

#include <algorithm>
#include <cmath>

#include "core/iso8601.hpp"
#include "gis/kiwi/geodetic_box.hpp"
#include "gis/model/text.hpp"

namespace kawara::gis {
namespace {

constexpr double kLevelM = 1e-3;  ///< a box askew by less is level
constexpr int kMetreDecimals = 4;
constexpr int kAngleDecimals = 6;
constexpr int kShareDecimals = 6;

LonLat LonLatOf(const core::Geodetic& g) {
  return {g.lon_rad * core::kDegFromRad, g.lat_rad * core::kDegFromRad};
}

class AttributeList {
 public:
  explicit AttributeList(std::string connector_id) : id_(std::move(connector_id)) {}
  void Text(const char* key, const std::string& value, const char* unit = "") {
    list_.push_back({id_, key, value, unit});
  }
  void Metres(const char* key, double value) { Text(key, Number(value, kMetreDecimals), "m"); }
  void Degrees(const char* key, double value_rad) {
    Text(key, Number(value_rad * core::kDegFromRad, kAngleDecimals), "deg");
  }
  void Share(const char* key, double value) { Text(key, Number(value, kShareDecimals), "1"); }
  void Time(const char* key, core::UtcTime t) {
    if (t.IsSet()) Text(key, core::FormatIso8601(t));
  }
  std::vector<Attribute> Take() { return std::move(list_); }

 private:
  std::string id_;
  std::vector<Attribute> list_;
};

std::vector<Attribute> AttributesOf(const core::ChangedObject& object, double heading_rad,
                                    double north_rad) {
  AttributeList list(ConnectorId(object));
  list.Text("revision", std::to_string(object.revision), "1");
  list.Text("state", core::ToString(object.state));
  list.Text("class", core::ToString(object.size_class));
  list.Share("class_probability", object.class_probability);
  list.Share("existence_probability", object.existence_probability);
  list.Metres("length", object.box.size_m.x());
  list.Metres("width", object.box.size_m.y());
  list.Metres("height", object.box.size_m.z());
  list.Degrees("heading", heading_rad);
  if (object.second_heading_rad)
    list.Degrees("second_heading", *object.second_heading_rad - north_rad);
  constexpr std::array<const char*, 6> kSdKeys{"sd_east",   "sd_north", "sd_up",
                                               "sd_length", "sd_width", "sd_height"};
  const auto sd = [&object](Eigen::Index i) { return std::sqrt(object.covariance(i, i)); };
  for (std::size_t i = 0; i < kSdKeys.size(); ++i)
    list.Metres(kSdKeys[i], sd(static_cast<Eigen::Index>(i)));
  list.Degrees("sd_heading", sd(6));
  list.Text("sides_seen", SidesSeen(object));
  list.Text("voxels", std::to_string(object.voxels), "1");
  list.Text("votes", std::to_string(object.votes), "1");
  list.Time("last_absent", object.last_absent);
  list.Time("first_seen", object.first_seen);
  list.Time("last_seen", object.last_seen);
  for (const std::string& robot : object.robots) list.Text("robot", robot);
  return list.Take();
}

/// Between the two edges, at a share of the way.
core::Geodetic Across(const core::RoadStation& station, const core::LocalEnu& map, double share) {
  return map.ToGeodetic(station.left_m + share * (station.right_m - station.left_m));
}

}  // namespace

std::string ConnectorId(const core::ChangedObject& object) {
  return object.uid + "/" + std::to_string(object.revision);
}

std::string OutlineId(const core::ChangedObject& object) {
  return ConnectorId(object) + "/outline";
}

std::string SidesSeen(const core::ChangedObject& object) {
  std::string sides;
  for (std::size_t i = 0; i < core::kBoxSides; ++i) {
    if (!object.side_seen[i]) continue;
    if (!sides.empty()) sides += ' ';
    sides += core::ToString(static_cast<core::BoxSide>(i));
  }
  return sides;
}

ElementSet ElementsOf(const core::ChangedObject& object, const core::LocalEnu& map,
                      core::UtcTime begin) {
  const GeodeticBox box = GeodeticOf(object.box, map);
  const auto by_height = [](const core::Geodetic& a, const core::Geodetic& b) {
    return a.h_ellipsoidal_m < b.h_ellipsoidal_m;
  };
  const auto floor_end = box.apexes.begin() + 4;
  const auto [floor_low, floor_high] =
      std::minmax_element(box.apexes.begin(), floor_end, by_height);
  const auto top = std::max_element(floor_end, box.apexes.end(), by_height);
  double askew_m = floor_high->h_ellipsoidal_m - floor_low->h_ellipsoidal_m;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d above = core::NedBetween(box.apexes[i], box.apexes[i + 4]);
    askew_m = std::max(askew_m, above.head<2>().norm());
  }
  const std::uint32_t lossy = askew_m > kLevelM ? kLossy : 0U;
  const HeightPair height{floor_low->h_ellipsoidal_m,
                          top->h_ellipsoidal_m - floor_low->h_ellipsoidal_m};

  VectorElement outline{OutlineId(object), kClassBoxOutline, lossy, {}, height, begin};
  for (std::size_t i = 0; i <= 4; ++i) outline.line.push_back(LonLatOf(box.apexes[i % 4]));
  ElementSet set;
  set.vectors = {std::move(outline)};
  set.connector = {ConnectorId(object), kClassBox, lossy, LonLatOf(box.centre), height, begin,
                   object.uid};
  set.attributes = AttributesOf(object, box.heading_rad, object.box.heading_rad - box.heading_rad);
  return set;
}

std::string StationUid(const core::RoadStation& station) {
  return station.road + "@" + Number(station.along_m, 3);
}

ElementSet ElementsOf(const core::RoadStation& station, const core::LocalEnu& map,
                      core::UtcTime begin) {
  const std::string uid = StationUid(station);
  const std::string id = uid + "/" + core::FormatIso8601(begin);
  const char* const cls = station.passable_class == 0 ? kClassRoadBlocked : kClassRoadWidth;
  const core::Geodetic left = Across(station, map, 0.0), right = Across(station, map, 1.0);
  const bool gap = station.gap_end_m > station.gap_begin_m && station.road_width_m > 0.0;
  const core::Geodetic middle =
      Across(station, map,
             gap ? (station.gap_begin_m + station.gap_end_m) / 2.0 / station.road_width_m : 0.5);
  const HeightPair height{std::min(left.h_ellipsoidal_m, right.h_ellipsoidal_m),
                          std::abs(left.h_ellipsoidal_m - right.h_ellipsoidal_m)};
  ElementSet set;
  set.vectors = {
      {id + "/across", cls, kMultiLink, {LonLatOf(left), LonLatOf(right)}, height, begin}};
  set.connector = {id, cls, 0U, LonLatOf(middle), height, begin, uid};
  AttributeList list(id);
  list.Text("road", station.road);
  list.Metres("along", station.along_m);
  list.Metres("road_width", station.road_width_m);
  list.Metres("passable_width", station.passable_m);
  list.Metres("sd_passable_width", station.passable_sd_m);
  list.Metres("gap_begin", station.gap_begin_m);
  list.Metres("gap_end", station.gap_end_m);
  list.Share("unknown_share", station.unknown_share);
  list.Text("passable_class", std::to_string(station.passable_class), "1");
  list.Time("observed", station.observed);
  set.attributes = list.Take();
  return set;
}

}  // namespace kawara::gis
