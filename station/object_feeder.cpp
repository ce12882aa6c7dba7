#include "station/object_feeder.hpp"

#include <algorithm>
#include <utility>

namespace kawara::station {
namespace {

constexpr std::size_t kMostOpen = 4;
constexpr std::size_t kMostWaiting = 16;

bool Same(const core::Geodetic& a, const core::Geodetic& b) {
  return a.lat_rad == b.lat_rad && a.lon_rad == b.lon_rad && a.h_ellipsoidal_m == b.h_ellipsoidal_m;
}

}  // namespace

core::Expected<ObjectFeeder::Mission*> ObjectFeeder::Open(const std::string& robot,
                                                          const std::string& mission,
                                                          const core::Geodetic& origin) {
  const auto found = std::find_if(missions_.begin(), missions_.end(), [&](const Mission& m) {
    return m.robot == robot && m.name == mission && Same(m.origin, origin);
  });
  if (found != missions_.end()) {
    missions_.splice(missions_.begin(), missions_, found);
    return &missions_.front();
  }
  gis::RegisterConfig config;
  config.target = target_;
  config.origin = origin;
  config.survey = mission;
  config.who = robot;
  auto objects = gis::ObjectRegister::Open(config);
  if (!objects) return tl::unexpected(objects.error());
  missions_.push_front({robot, mission, origin, std::move(*objects)});
  if (missions_.size() > kMostOpen) {
    static_cast<void>(missions_.back().objects.Close());
    missions_.pop_back();
  }
  return &missions_.front();
}

void ObjectFeeder::Count(gis::Registered answer, std::uint64_t& what) {
  ++(answer == gis::Registered::kKnown ? counts_.known : what);
}

core::Expected<void> ObjectFeeder::Add(const comms::ObjectReport& report) {
  auto mission = Open(report.robot, report.mission, report.origin);
  if (!mission) return tl::unexpected(mission.error());
  // Times of the message, not of this machine: the log of a mission gives the same rows.
  const core::UtcTime told = std::max(report.object.last_seen, report.object.gone);
  const auto answer = (*mission)->objects.Register(report.object, {}, told);
  if (!answer) return tl::unexpected(answer.error());
  Count(*answer, counts_.revisions);
  return AddWaiting(**mission, report);
}

core::Expected<void> ObjectFeeder::AddWaiting(Mission& mission, const comms::ObjectReport& report) {
  for (auto texture = waiting_.begin(); texture != waiting_.end();) {
    if (texture->uid != report.object.uid || texture->revision != report.object.revision) {
      ++texture;
      continue;
    }
    const auto answer =
        mission.objects.RegisterTextures(texture->uid, texture->revision, texture->textures);
    if (!answer && answer.error().code != core::ErrorCode::kInvalidArgument)
      return tl::unexpected(answer.error());
    Count(answer.value_or(gis::Registered::kKnown), counts_.textures);
    texture = waiting_.erase(texture);
  }
  return {};
}

core::Expected<void> ObjectFeeder::Add(const comms::TextureReport& report) {
  const auto mission = std::find_if(missions_.begin(), missions_.end(), [&](const Mission& m) {
    return m.robot == report.robot && m.name == report.mission;
  });
  core::Expected<std::uint64_t> told = 0;
  if (mission != missions_.end()) told = mission->objects.LastRevision(report.uid);
  if (!told) return tl::unexpected(told.error());
  if (*told < report.revision) {
    waiting_.push_front(report);
    if (waiting_.size() > kMostWaiting) {
      waiting_.pop_back();
      ++counts_.orphans;
    }
    return {};
  }
  const auto answer =
      mission->objects.RegisterTextures(report.uid, report.revision, report.textures);
  if (!answer) return tl::unexpected(answer.error());
  Count(*answer, counts_.textures);
  return {};
}

core::Expected<void> ObjectFeeder::Add(const comms::RoadReport& report) {
  auto mission = Open(report.robot, report.mission, report.origin);
  if (!mission) return tl::unexpected(mission.error());
  core::UtcTime told;
  for (const core::RoadStation& station : report.stations) told = std::max(told, station.observed);
  const auto added = (*mission)->objects.RegisterStations(report.stations, told, told);
  if (!added) return tl::unexpected(added.error());
  counts_.stations += *added;
  counts_.known += report.stations.size() - *added;
  return {};
}

core::Expected<void> ObjectFeeder::Close() {
  core::Expected<void> done;
  for (Mission& mission : missions_)
    if (auto closed = mission.objects.Close(); !closed) done = closed;
  missions_.clear();
  return done;
}

}  // namespace kawara::station
