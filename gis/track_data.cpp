#include "gis/track_data.hpp"

#include <ogrsf_frmts.h>

#include <algorithm>
#include <map>
#include <utility>

#include "gis/ogr_dataset.hpp"
#include "gis/rtk_colour.hpp"

namespace kawara::gis {
namespace {

core::RtkState RtkFromText(const std::string& text) {
  for (const RtkColour& c : kRtkColours)
    if (text == core::ToString(c.state)) return c.state;
  return core::RtkState::kNone;
}

core::Geodetic PositionAt(const OGRFeature& row, int first_field) {
  return {row.GetFieldAsDouble(first_field) * core::kRadFromDeg,
          row.GetFieldAsDouble(first_field + 1) * core::kRadFromDeg,
          row.GetFieldAsDouble(first_field + 2)};
}

template <class Point>
void SortByTime(std::vector<Point>& points) {
  std::sort(points.begin(), points.end(),
            [](const Point& a, const Point& b) { return a.time < b.time; });
}

}  // namespace

core::Expected<std::vector<MissionTrack>> LoadTracks(const std::string& store) {
  auto dataset = OgrDataset::Open(store, true);
  if (!dataset) return tl::unexpected(dataset.error());
  std::map<std::pair<std::string, std::string>, MissionTrack> found;
  const auto track = [&found](const OGRFeature& row) -> MissionTrack& {
    const std::pair<std::string, std::string> key{row.GetFieldAsString(0), row.GetFieldAsString(1)};
    MissionTrack& t = found[key];
    t.robot = key.first;
    t.mission = key.second;
    return t;
  };
  auto read = dataset->ForEach(
      "SELECT robot, mission, gps_ns, rtk_state, lat_deg, lon_deg, h_ellipsoidal_m FROM obs_pose",
      [&](const OGRFeature& row) {
        track(row).poses.push_back({core::GpsTime::FromNs(row.GetFieldAsInteger64(2)),
                                    PositionAt(row, 4), RtkFromText(row.GetFieldAsString(3))});
      });
  if (read)
    read = dataset->ForEach(
        "SELECT robot, mission, gps_ns, stage, lat_deg, lon_deg, h_ellipsoidal_m, yaw_deg FROM "
        "obs_panorama WHERE lat_deg IS NOT NULL",
        [&](const OGRFeature& row) {
          track(row).pictures.push_back({core::GpsTime::FromNs(row.GetFieldAsInteger64(2)),
                                         PositionAt(row, 4), row.GetFieldAsDouble(7),
                                         std::string(row.GetFieldAsString(3)) == "full"});
        });
  if (read)
    read = dataset->ForEach(
        "SELECT robot, mission, length_m FROM trajectory",
        [&](const OGRFeature& row) { track(row).length_m = row.GetFieldAsDouble(2); });
  if (!read) return tl::unexpected(read.error());
  std::vector<MissionTrack> tracks;
  for (auto& [key, t] : found) {
    SortByTime(t.poses);
    SortByTime(t.pictures);
    if (!t.poses.empty() || !t.pictures.empty()) tracks.push_back(std::move(t));
  }
  return tracks;
}

}  // namespace kawara::gis
