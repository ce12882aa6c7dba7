#include "gis/tracks.hpp"

#include <ogrsf_frmts.h>

#include <algorithm>
#include <utility>

namespace kawara::gis {
namespace {

constexpr std::size_t kMostTracks = 16;
constexpr std::size_t kGrowthDivisor = 512;

std::string Where(const std::string& robot, const std::string& mission) {
  return " WHERE robot = " + SqlText(robot) + " AND mission = " + SqlText(mission);
}

}  // namespace

core::Expected<void> Tracks::Add(OgrDataset& dataset, const std::string& robot,
                                 const std::string& mission, const TrackVertex& vertex) {
  const auto found = std::find_if(tracks_.begin(), tracks_.end(), [&](const Track& t) {
    return t.robot == robot && t.mission == mission;
  });
  if (found == tracks_.end()) {
    Track track{.robot = robot, .mission = mission, .vertices = {}};
    if (auto loaded = Load(dataset, track); !loaded) return loaded;
    track.unwritten = 1;
    tracks_.push_front(std::move(track));
    if (tracks_.size() <= kMostTracks) return {};
    if (auto written = Write(dataset, tracks_.back()); !written) return written;
    tracks_.pop_back();
    return {};
  }
  tracks_.splice(tracks_.begin(), tracks_, found);
  std::vector<TrackVertex>& line = found->vertices;
  const auto at =
      std::lower_bound(line.begin(), line.end(), vertex.gps_ns,
                       [](const TrackVertex& v, std::int64_t ns) { return v.gps_ns < ns; });
  if (at != line.end() && at->gps_ns == vertex.gps_ns) {
    *at = vertex;
    found->corrected = true;
  } else {
    line.insert(at, vertex);
  }
  ++found->unwritten;
  return {};
}

core::Expected<void> Tracks::Write(OgrDataset& dataset, bool all) {
  for (Track& track : tracks_) {
    const bool grown = track.unwritten > track.vertices.size() / kGrowthDivisor;
    if (track.unwritten == 0 || !(all || grown || track.corrected)) continue;
    if (auto written = Write(dataset, track); !written) return written;
  }
  return {};
}

core::Expected<void> Tracks::Load(OgrDataset& dataset, Track& track) {
  track.vertices.clear();
  return dataset.ForEach(
      "SELECT gps_ns, lat_deg, lon_deg, h_ellipsoidal_m FROM obs_pose" +
          Where(track.robot, track.mission) + " ORDER BY gps_ns",
      [&track](const OGRFeature& row) {
        track.vertices.push_back({row.GetFieldAsInteger64(0), row.GetFieldAsDouble(1),
                                  row.GetFieldAsDouble(2), row.GetFieldAsDouble(3)});
      });
}

core::Expected<void> Tracks::Write(OgrDataset& dataset, Track& track) {
  track.unwritten = 0;
  track.corrected = false;
  if (track.vertices.size() < 2) return {};  // not a line yet
  OGRLayer* layer = dataset.Layer(kTrajectory);
  if (layer == nullptr)
    return core::Fail(core::ErrorCode::kIo, "the store has lost its layer trajectory");
  const auto fid = dataset.QueryInteger("SELECT fid + 0 AS n FROM trajectory" +
                                        Where(track.robot, track.mission));
  if (!fid) return tl::unexpected(fid.error());
  OGRFeature feature(layer->GetLayerDefn());
  if (*fid) feature.SetFID(**fid);
  Fill(feature, track.robot, track.mission, track.vertices);
  if (auto written = dataset.Write(*layer, feature); !written) return written;
  return dataset.Sync(*layer, "t_end");
}

core::Expected<void> Tracks::Mend(OgrDataset& dataset) {
  std::vector<Track> stale;
  auto found = dataset.ForEach(
      "SELECT p.robot AS robot, p.mission AS mission FROM (SELECT robot, mission, count(*) AS n, "
      "max(gps_ns) AS last FROM obs_pose GROUP BY robot, mission) p LEFT JOIN trajectory t ON "
      "t.robot = p.robot AND t.mission = p.mission WHERE p.n > 1 AND (t.poses IS NULL OR t.poses "
      "<> "
      "p.n OR t.last_gps_ns <> p.last)",
      [&stale](const OGRFeature& row) {
        stale.push_back(
            {.robot = row.GetFieldAsString(0), .mission = row.GetFieldAsString(1), .vertices = {}});
      });
  if (!found || stale.empty()) return found;
  if (auto begun = dataset.Begin(); !begun) return begun;
  core::Expected<void> done;
  for (Track& track : stale) {
    if (done) done = Load(dataset, track);
    if (done) done = Write(dataset, track);
  }
  if (done) done = dataset.Commit();
  if (!done) dataset.Rollback();
  return done;
}

}  // namespace kawara::gis
