#include "vision/change/change_watch.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::vision {
namespace {

/// What lies so far within another thing's floor is a piece of it.
constexpr double kPiece = 0.6;
/// What is nearer to a thing may belong to it.
constexpr double kBeside = 0.75;  // m
/// Of a disc's rim: a thing that comes so near may be cut by it.
constexpr double kRim = 0.5;  // m
/// Beyond reach a thing is left behind, and a station too far to be judged.
constexpr double kBeyond = 1.0;  // m
/// Deviation of the length of a thing whose end is out of sight.
constexpr double kOpenEnd = 1.5;  // m
/// Between two looks a thing that grows less has been seen to its end.
constexpr double kStill = 0.2;  // m
/// A station is told of when more of it was seen than not, and anew when as much more was seen, or
/// its width has changed by this.
constexpr double kMostUnknown = 0.5, kLessUnknown = 0.25, kOtherWidth = 0.10;

Eigen::Vector2d Plane(const Eigen::Vector3d& p) { return p.head<2>(); }

double NearestOf(const core::UprightBox& box, const Eigen::Vector2d& from) {
  const Eigen::Vector2d off = from - Plane(box.centre_m);
  return std::hypot(std::max(0.0, std::abs(off.dot(box.Forward())) - box.size_m.x() / 2),
                    std::max(0.0, std::abs(off.dot(box.Left())) - box.size_m.y() / 2));
}

core::UprightBox Wider(core::UprightBox box, double by_m) {
  box.size_m.head<2>() += Eigen::Vector2d::Constant(2.0 * by_m);
  return box;
}

bool Meet(const core::UprightBox& a, const core::UprightBox& b) { return SharedFloor(a, b) > 0.0; }

}  // namespace

ChangeWatch::ChangeWatch(KnownPlace place, const WatchOptions& options)
    : place_(std::move(place)),
      options_(options),
      tracker_(options.tracker),
      own_ground_(place_.reference.ground.empty()) {}

bool ChangeWatch::IsDue(const Eigen::Vector3d& here) const {
  return !last_look_ || (Plane(here) - Plane(*last_look_)).norm() >= options_.step_m;
}

bool ChangeWatch::Align(const VoxelMap& map, const Eigen::Vector3d& here, ChangeNews& news) {
  const bool due =
      !last_alignment_ || (Plane(here) - Plane(*last_alignment_)).norm() >= options_.align_step_m;
  if (!options_.align || !due) return fits_;
  last_alignment_ = here;
  auto alignment = AlignReference(map, place_, options_.finder.change.rule, options_.alignment);
  fits_ = alignment.has_value();
  if (!fits_) {
    news.trouble = alignment.error().message;
    return fits_;
  }
  options_.finder.width.fit_covariance_m2 = alignment->plane_covariance_m2;
  if (alignment->surfaces > 0) {
    reference_from_map_ = alignment->reference_from_map;
    news.alignment = *alignment;
  }
  return fits_;
}

ChangeNews ChangeWatch::Look(const VoxelMap& map, const Eigen::Vector3d& here, double known_m,
                             core::UtcTime now) {
  ChangeNews news;
  std::optional<Eigen::Vector2d> ahead;
  if (last_look_ && Plane(here) != Plane(*last_look_))
    ahead = (Plane(here) - Plane(*last_look_)).normalized();
  last_look_ = here;
  const FinderOptions& finder = options_.finder;
  if (own_ground_)
    place_.reference.ground =
        EstimateGround(map, place_.road, finder.change.rule, finder.change.margin_m + 1.0);
  if (Align(map, here, news)) {
    Findings findings =
        FindChanges(map, place_, reference_from_map_, finder, PlaneDisc{Plane(here), known_m});
    findings.ahead = ahead;
    KeepSure(findings, here, known_m);
    DoubtOpenEnds(findings, here);
    news.revisions = tracker_.Update(findings, now, place_.reference.Date());
    for (const core::ChangedObject& object : news.revisions) {
      if (object.state == core::ChangeState::kGone)
        open_.erase(object.uid);
      else
        open_.insert(object.uid);
    }
    AddStations(findings, here, known_m, now, news);
  }
  AddSettled(here, news);
  return news;
}

void ChangeWatch::DoubtOpenEnds(Findings& findings, const Eigen::Vector3d& here) {
  for (FoundChange& change : findings.changes) {
    core::ChangedObject& object = change.object;
    Eigen::Vector2d farthest = Eigen::Vector2d::Zero();
    for (const ChangePoint& p : change.region.points)
      if (const Eigen::Vector2d off = Plane(p.position_m) - Plane(here);
          off.norm() > farthest.norm())
        farthest = off;
    const auto stands_still = [&](const core::UprightBox& last) {
      return Meet(last, object.box) &&
             (object.box.size_m - last.size_m).head<2>().maxCoeff() < kStill;
    };
    const bool in_sight = farthest.norm() < options_.reach_m - kBeyond &&
                          std::any_of(last_boxes_.begin(), last_boxes_.end(), stands_still);
    bool was_whole = false;
    for (const core::ChangedObject& known : tracker_.objects()) {
      if (!Meet(known.box, object.box)) continue;
      if (in_sight) whole_.insert(known.uid);
      was_whole = was_whole || whole_.contains(known.uid);
    }
    if (in_sight || was_whole) continue;
    const bool along =
        std::abs(farthest.dot(object.box.Forward())) > std::abs(farthest.dot(object.box.Left()));
    const Eigen::Vector2d axis = along ? object.box.Forward() : object.box.Left();
    // One end is known, so that the centre moves by half of what the size does, away from here.
    Eigen::Matrix<double, core::ChangedObject::kParameters, 1> slope =
        Eigen::Matrix<double, core::ChangedObject::kParameters, 1>::Zero();
    slope.head<2>() = (axis.dot(farthest) > 0.0 ? 0.5 : -0.5) * axis;
    slope[along ? 3 : 4] = 1.0;
    object.covariance += kOpenEnd * kOpenEnd * slope * slope.transpose();
  }
  last_boxes_.clear();
  for (const FoundChange& change : findings.changes) last_boxes_.push_back(change.object.box);
}

// What lies whole in memory and is a thing for sure, or is known already.
void ChangeWatch::KeepSure(Findings& findings, const Eigen::Vector3d& here, double known_m) {
  // A piece of a thing is not a thing: they come largest first.
  std::vector<core::UprightBox> things;
  std::erase_if(findings.changes, [&](const FoundChange& change) {
    const core::UprightBox& box = change.object.box;
    const double floor_m2 = box.size_m.x() * box.size_m.y();
    const bool piece = std::any_of(things.begin(), things.end(), [&](const auto& thing) {
      return SharedFloor(thing, box) > kPiece * floor_m2;
    });
    if (!piece) things.push_back(box);
    return piece;
  });
  const PlaneDisc whole{Plane(here), known_m - kRim};
  std::vector<Candidate> candidates;
  std::erase_if(findings.changes, [&](const FoundChange& change) {
    const auto& points = change.region.points;
    if (!std::all_of(points.begin(), points.end(),
                     [&](const ChangePoint& p) { return whole.Contains(Plane(p.position_m)); }))
      return true;
    const core::UprightBox& box = change.object.box;
    const auto& known = tracker_.objects();
    if (std::any_of(known.begin(), known.end(),
                    [&](const auto& object) { return Meet(object.box, box); }))
      return false;
    // Beside a thing whose end has not been seen stands more of it.
    if (std::any_of(known.begin(), known.end(), [&](const auto& object) {
          return open_.contains(object.uid) && !whole_.contains(object.uid) &&
                 Meet(Wider(object.box, kBeside), box);
        }))
      return true;
    Candidate candidate{box, 1};
    for (const Candidate& before : candidates_)
      if (Meet(before.box, box)) candidate.looks = std::max(candidate.looks, before.looks + 1);
    candidates.push_back(candidate);
    return change.object.existence_probability < options_.min_existence ||
           candidate.looks < options_.min_looks;
  });
  candidates_ = std::move(candidates);
}

void ChangeWatch::AddStations(const Findings& findings, const Eigen::Vector3d& here, double known_m,
                              core::UtcTime now, ChangeNews& news) {
  const PlaneDisc judged{Plane(here), std::min(known_m, options_.reach_m + kBeyond)};
  for (const core::RoadStation& station : findings.stations) {
    if (station.unknown_share > kMostUnknown || !judged.Contains(Plane(station.left_m)) ||
        !judged.Contains(Plane(station.right_m)))
      continue;
    core::RoadStation& told =
        told_stations_[{station.road, std::llround(station.along_m / RoadAxis::kStep)}];
    const bool worth = !told.observed.IsSet() || told.passable_class != station.passable_class ||
                       std::abs(told.passable_m - station.passable_m) > kOtherWidth ||
                       told.unknown_share - station.unknown_share > kLessUnknown;
    if (!worth) continue;
    told = station;
    told.observed = now;
    news.stations.push_back(told);
  }
}

void ChangeWatch::AddSettled(const Eigen::Vector3d& here, ChangeNews& news) {
  for (const core::ChangedObject& object : tracker_.objects()) {
    const auto open = open_.find(object.uid);
    if (open == open_.end() || NearestOf(object.box, Plane(here)) <= options_.reach_m + kBeyond)
      continue;
    open_.erase(open);
    news.settled.push_back(object);
  }
}

std::vector<core::ChangedObject> ChangeWatch::Settle() {
  std::vector<core::ChangedObject> settled;
  for (const core::ChangedObject& object : tracker_.objects())
    if (open_.erase(object.uid) > 0) settled.push_back(object);
  return settled;
}

}  // namespace kawara::vision
