#include "onboard/changes/change_run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "gis/kiwi/object_register.hpp"
#include "onboard/changes/change_input.hpp"
#include "onboard/changes/reference_run.hpp"
#include "vision/change/reference_file.hpp"

namespace kawara::changes {
namespace {

/// The reference with the road and ground that were given beside it.
core::Expected<vision::KnownPlace> PlaceOf(const ChangeRunOptions& options,
                                           vision::ReferenceMap reference) {
  ReferenceOptions files;
  files.local = options.local;
  files.roads = options.roads;
  files.road_name = options.road_name;
  files.ground = options.ground;
  files.geoid_separation_m = options.geoid_separation_m;
  files.say = options.say;
  if (!options.roads.empty()) {
    reference.roads.clear();
    reference.road_axes.clear();
    if (auto done = AddRoads(files, reference); !done) return tl::unexpected(done.error());
  }
  if (reference.roads.empty())
    return core::Fail(
        core::ErrorCode::kInvalidArgument,
        "no road to look at: give its area (--road FILE), or a reference that has it");
  if (!options.ground.empty())
    if (auto done = AddGround(files, reference); !done) return tl::unexpected(done.error());
  return vision::KnownPlace::Of(std::move(reference));
}

/// Clouds are told by one point a voxel, from one place.
void SuitClouds(vision::FinderOptions& finder) {
  finder.change.rule = {.min_hits = 1, .min_weight = 0.0, .min_hit_share = 0.0};
  finder.change.min_view_spread = 0.0;
  finder.region.company = 2;
  finder.region.min_skirt_share = 0.0;
  finder.region.link_m = 0.5;
  finder.region.min_hidden_m2 = 0.0;
  finder.box.correlated_voxels = 2.0;
}

void SayAlignment(const ChangeRunOptions& options, const vision::Alignment& a) {
  if (!options.say) return;
  std::array<char, 200> line{};
  std::snprintf(line.data(), line.size(),
                "the map lies %+.3f m east, %+.3f m north, %+.3f m up and %+.2f deg off the "
                "reference (median %.3f m before, %.3f m after, on %zu voxels)",
                -a.shift_m.x(), -a.shift_m.y(), -a.shift_m.z(), -a.turn_rad * core::kDegFromRad,
                a.residual_before_m, a.residual_m, a.surfaces);
  options.say(line.data());
}

core::Expected<void> Register(const ChangeRunOptions& options, const vision::Findings& findings,
                              core::UtcTime last_absent, ChangeRunResult& result) {
  gis::RegisterConfig config;
  config.target = options.out;
  config.origin = result.origin;
  config.survey = options.survey;
  config.who = options.robot.empty() ? "kawara-changes" : options.robot;
  auto objects = gis::ObjectRegister::Open(config);
  if (!objects) return tl::unexpected(objects.error());
  auto known = objects->ObjectsAt(options.time);
  if (!known) return tl::unexpected(known.error());
  vision::TrackerOptions tracking;
  tracking.uid_prefix = options.survey;
  tracking.robot = options.robot;
  tracking.taken = [&](const std::string& uid) {
    const auto last = objects->LastRevision(uid);
    return last && *last > 0;
  };
  vision::ObjectTracker tracker(tracking);
  tracker.TakeUp(std::move(*known));
  result.revisions = tracker.Update(findings, options.time, last_absent);
  for (const core::ChangedObject& revision : result.revisions)
    if (auto done = objects->Register(revision); !done) return tl::unexpected(done.error());
  for (core::RoadStation& station : result.stations)
    if (station.unknown_share < 1.0) station.observed = options.time;
  if (auto done = objects->RegisterStations(result.stations, options.time); !done)
    return tl::unexpected(done.error());
  result.objects = tracker.objects();
  return objects->Close();
}

}  // namespace

core::Expected<ChangeRunResult> RunChanges(const ChangeRunOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  ChangeRunResult result;
  vision::ReferenceMap reference;
  if (!options.reference.empty()) {
    auto read = vision::ReadReference(options.reference);
    if (!read) return tl::unexpected(read.error());
    reference = std::move(*read);
  }
  std::optional<core::Geodetic> origin = options.origin ? options.origin : reference.origin;
  auto input = ReadInput(options, origin);
  if (!input) return tl::unexpected(input.error());
  result.points = input->points;
  if (!origin || input->from_pictures) origin = input->origin ? input->origin : origin;
  if (!origin)
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "nobody says where the map's origin lies: give it, --origin LAT,LON,HEIGHT");
  if (auto same = vision::KnownPlace::CheckOrigin(reference, *origin); !same)
    return tl::unexpected(same.error());
  reference.origin = result.origin = *origin;
  auto place = PlaceOf(options, std::move(reference));
  if (!place) return tl::unexpected(place.error());

  vision::FinderOptions finder = options.finder;
  if (!input->from_pictures) SuitClouds(finder);
  if (place->reference.ground.empty()) {
    place->reference.ground = vision::EstimateGround(input->map, place->road, finder.change.rule,
                                                     finder.change.margin_m + 1.0);
    if (options.say)
      options.say("the reference has no ground: its height is estimated from the points");
  }
  if (options.align) {
    auto alignment = vision::AlignReference(input->map, *place, finder.change.rule, {});
    if (!alignment) return tl::unexpected(alignment.error());
    result.alignment = *alignment;
    finder.width.fit_covariance_m2 = alignment->plane_covariance_m2;
    if (alignment->surfaces > 0) SayAlignment(options, *alignment);
    if (const std::string unchecked = vision::Unchecked(*alignment);
        options.say && !unchecked.empty())
      options.say(unchecked);
  }
  const vision::Findings findings =
      vision::FindChanges(input->map, *place, result.alignment.reference_from_map, finder);
  if (findings.look.surface == 0 && findings.look.ground_seen.empty())
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      findings.look.no_ground > 0
                          ? "the points lie on the road but nowhere is the ground's height known"
                          : "no point lies on the road: are road and points in one system?");
  result.stations = findings.stations;
  for (const core::RoadStation& station : result.stations) {
    if (station.unknown_share >= 0.5) continue;
    result.narrowest_m = result.stations_seen == 0
                             ? station.passable_m
                             : std::min(result.narrowest_m, station.passable_m);
    ++result.stations_seen;
  }
  if (auto done = Register(options, findings, place->reference.Date(), result); !done)
    return tl::unexpected(done.error());
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace kawara::changes
