#include "vision/change/object_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <limits>

namespace kawara::vision {
namespace {

double Distance(const core::UprightBox& a, const core::UprightBox& b) {
  return (a.centre_m - b.centre_m).head<2>().norm();
}

double Volume(const core::UprightBox& box) { return box.size_m.prod(); }

double Floor(const core::UprightBox& box) { return box.size_m.x() * box.size_m.y(); }

double CentreSd(const core::ChangedObject& object) {
  return std::sqrt(std::max(0.0, object.covariance(0, 0) + object.covariance(1, 1)));
}

/// In so many dimensions: length and width, or all three.
bool SameSize(const core::ChangedObject& a, const core::ChangedObject& b, int dimensions = 3) {
  for (int i = 0; i < dimensions; ++i) {
    const double sd = std::sqrt(a.covariance(3 + i, 3 + i) + b.covariance(3 + i, 3 + i));
    constexpr double kLeast = 0.3;  // m
    if (std::abs(a.box.size_m[i] - b.box.size_m[i]) > kLeast + 2.0 * sd) return false;
  }
  return true;
}

/// By more than what was published allows for, and more than anybody cares for.
bool IsOther(const core::ChangedObject& published, const core::ChangedObject& seen) {
  constexpr double kLeast = 0.10, kSds = 0.5;  // m
  const auto other = [&](double by, double variance) {
    return std::abs(by) > std::max(kLeast, kSds * std::sqrt(std::max(0.0, variance)));
  };
  for (int i = 0; i < 3; ++i)
    if (other(seen.box.centre_m[i] - published.box.centre_m[i], published.covariance(i, i)) ||
        other(seen.box.size_m[i] - published.box.size_m[i], published.covariance(3 + i, 3 + i)))
      return true;
  return false;
}

/// Deviation of the floor's place and size together.
double FloorDoubt(const core::ChangedObject& object) {
  const auto& c = object.covariance;
  return std::sqrt(std::max(0.0, c(0, 0) + c(1, 1) + c(3, 3) + c(4, 4)));
}

/// A look that tells nothing that is not known better: it shows a part of the thing, or the whole
/// as well as it can from there.
bool TellsLess(const core::ChangedObject& seen, const core::ChangedObject& known) {
  constexpr double kInside = 0.8, kSurer = 0.8, kUnsure = 1.3;
  const double seen_m = FloorDoubt(seen), known_m = FloorDoubt(known);
  const bool part = Floor(seen.box) < kInside * Floor(known.box) &&
                    SharedFloor(seen.box, known.box) > kInside * Floor(seen.box);
  if (part) return seen_m > kSurer * known_m;
  return seen_m > kUnsure * known_m && SameSize(seen, known, 2);
}

int SidesSeen(const core::ChangedObject& object) {
  return static_cast<int>(std::count(object.side_seen.begin(), object.side_seen.end(), true));
}

void AddRobots(core::ChangedObject& object, const std::vector<std::string>& robots) {
  for (const std::string& robot : robots)
    if (std::find(object.robots.begin(), object.robots.end(), robot) == object.robots.end())
      object.robots.push_back(robot);
}

}  // namespace

bool ObjectTracker::Same(const core::UprightBox& a, const core::UprightBox& b) const {
  const double length = std::min(a.size_m.head<2>().maxCoeff(), b.size_m.head<2>().maxCoeff());
  return Distance(a, b) < std::max(options_.same_m, options_.same_share * length) ||
         SharedFloor(a, b) > options_.same_floor * std::min(Floor(a), Floor(b));
}

bool ObjectTracker::IsPartOfAnother(std::size_t known,
                                    const std::vector<core::ChangedObject>& seen) const {
  constexpr double kMost = 0.6;
  const core::UprightBox& box = objects_[known].box;
  return this_pass_[known] && std::any_of(seen.begin(), seen.end(), [&](const auto& other) {
           return SharedFloor(box, other.box) > kMost * Floor(box);
         });
}

void ObjectTracker::TakeUp(std::vector<core::ChangedObject> known, bool this_pass) {
  for (core::ChangedObject& object : known) {
    last_number_ = std::max(last_number_, NumberOf(object.uid));
    if (object.state == core::ChangeState::kGone) continue;
    objects_.push_back(std::move(object));
    this_pass_.push_back(this_pass);
  }
}

std::uint64_t ObjectTracker::NumberOf(const std::string& uid) const {
  const std::string start = options_.uid_prefix + "-";
  return uid.starts_with(start) ? std::strtoull(uid.c_str() + start.size(), nullptr, 10) : 0;
}

std::string ObjectTracker::NextUid() {
  for (;;) {
    std::string uid = options_.uid_prefix + "-" + std::to_string(++last_number_);
    if (!options_.taken || !options_.taken(uid)) return uid;
  }
}

// Bare ground where it stood: the robot looked, and nothing is there.
bool ObjectTracker::IsGone(const core::ChangedObject& object, const Findings& findings) const {
  const core::UprightBox& box = object.box;
  const auto apexes = box.Apexes();
  if (findings.within && !std::all_of(apexes.begin(), apexes.end(), [&](const auto& apex) {
        return findings.within->Contains(apex.template head<2>());
      }))
    return false;
  const Eigen::Vector2d middle = box.centre_m.head<2>();
  if (findings.within && findings.ahead &&
      (middle - findings.within->centre_m).dot(*findings.ahead) > 0.0)
    return false;
  int all = 0, bare = 0;
  constexpr double kStep = ChangePoints::kGroundCell;
  // Without its rim, which may lie on ground beside it.
  const double along = std::max(kStep, box.size_m.x() / 2.0 - 0.3);
  const double across = std::max(kStep, box.size_m.y() / 2.0 - 0.3);
  const int columns = 1 + static_cast<int>(2.0 * along / kStep);
  const int rows = 1 + static_cast<int>(2.0 * across / kStep);
  for (int i = 0; i < columns; ++i)
    for (int k = 0; k < rows; ++k) {
      const double a = i * kStep - along, b = k * kStep - across;
      ++all;
      bare += findings.look.GroundSeen(middle + a * box.Forward() + b * box.Left()) ? 1 : 0;
    }
  if (bare < options_.gone_ground_share * all) return false;
  int standing = 0;
  for (const ChangePoint& p : findings.look.points) {
    const Eigen::Vector2d off = p.position_m.head<2>() - middle;
    if (std::abs(off.dot(box.Forward())) < box.size_m.x() / 2 &&
        std::abs(off.dot(box.Left())) < box.size_m.y() / 2)
      ++standing;
  }
  constexpr int kStray = 3;
  return standing <= kStray;
}

bool ObjectTracker::Revise(core::ChangedObject& object, const core::ChangedObject& seen,
                           bool this_pass, core::UtcTime now) const {
  if (TellsLess(seen, object)) {
    object.last_seen = now;
    AddRobots(object, seen.robots);
    if (this_pass) return false;
    ++object.revision;
    object.state = core::ChangeState::kConfirmed;
    return true;
  }
  const double shift = Distance(object.box, seen.box);
  const double sd = std::hypot(CentreSd(object), CentreSd(seen));
  const double ratio = Volume(seen.box) / std::max(1e-3, Volume(object.box));
  core::ChangeState state = core::ChangeState::kConfirmed;
  if (!this_pass) {
    if (shift > options_.moved_m + 2.0 * sd)
      state = core::ChangeState::kMoved;
    else if (ratio > 1.0 + options_.grown_share && !SameSize(object, seen))
      state = core::ChangeState::kGrown;
  } else if (object.state == core::ChangeState::kNew) {
    state = core::ChangeState::kNew;
  }
  // Within a pass a look tells more or nothing: what was published is bettered, not repeated.
  constexpr double kBetter = 0.7;
  const bool worth = !this_pass || IsOther(object, seen) || SidesSeen(seen) > SidesSeen(object) ||
                     CentreSd(seen) < kBetter * CentreSd(object);
  object.last_seen = now;
  AddRobots(object, seen.robots);
  if (!worth) return false;
  const core::ChangedObject before = object;
  object = seen;
  object.uid = before.uid;
  object.revision = before.revision + 1;
  object.state = state;
  object.first_seen = state == core::ChangeState::kMoved ? now : before.first_seen;
  object.last_absent = before.last_absent;
  object.last_seen = now;
  object.robots = before.robots;
  return true;
}

std::optional<core::ChangedObject> ObjectTracker::Reissue(const std::string& uid) {
  for (core::ChangedObject& object : objects_) {
    if (object.uid != uid) continue;
    ++object.revision;
    return object;
  }
  return {};
}

std::vector<core::ChangedObject> ObjectTracker::Update(const Findings& findings, core::UtcTime now,
                                                       core::UtcTime last_absent) {
  std::vector<core::ChangedObject> revisions;
  std::vector<core::ChangedObject> seen;
  for (const FoundChange& change : findings.changes) {
    seen.push_back(change.object);
    if (!options_.robot.empty()) seen.back().robots = {options_.robot};
  }
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> match(seen.size(), kNone);  // which known object
  std::vector<bool> met(objects_.size(), false);
  // Those that share most floor first, then the nearest; each in one pair.
  for (;;) {
    double best = -std::numeric_limits<double>::max();
    std::size_t best_seen = kNone, best_known = kNone;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (match[i] != kNone) continue;
      for (std::size_t k = 0; k < objects_.size(); ++k) {
        if (met[k] || !Same(seen[i].box, objects_[k].box)) continue;
        const double shared_m2 = SharedFloor(seen[i].box, objects_[k].box);
        const double score = shared_m2 > 0.0 ? shared_m2 : -Distance(seen[i].box, objects_[k].box);
        if (score <= best) continue;
        best = score;
        best_seen = i;
        best_known = k;
      }
    }
    if (best_seen == kNone) break;
    match[best_seen] = best_known;
    met[best_known] = true;
  }
  std::vector<bool> gone(objects_.size(), false);
  for (std::size_t k = 0; k < gone.size(); ++k) gone[k] = !met[k] && IsGone(objects_[k], findings);
  // What has left its place and a thing of its size that is new nearby are one that moved.
  for (std::size_t k = 0; k < gone.size(); ++k) {
    if (!gone[k]) continue;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (match[i] != kNone || !SameSize(objects_[k], seen[i]) ||
          Distance(objects_[k].box, seen[i].box) > options_.moved_away_m)
        continue;
      match[i] = k;
      gone[k] = false;
      break;
    }
  }
  for (std::size_t k = 0; k < gone.size(); ++k)
    if (!met[k] && IsPartOfAnother(k, seen)) gone[k] = true;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (match[i] != kNone) {
      core::ChangedObject& object = objects_[match[i]];
      if (Revise(object, seen[i], this_pass_[match[i]], now)) revisions.push_back(object);
      this_pass_[match[i]] = true;
      continue;
    }
    core::ChangedObject object = seen[i];
    object.uid = NextUid();
    object.revision = 1;
    object.state = core::ChangeState::kNew;
    object.last_absent = last_absent;
    object.first_seen = object.last_seen = now;
    objects_.push_back(object);
    this_pass_.push_back(true);
    revisions.push_back(std::move(object));
  }
  for (std::size_t k = gone.size(); k-- > 0;) {
    if (!gone[k]) continue;
    core::ChangedObject object = objects_[k];
    ++object.revision;
    object.state = core::ChangeState::kGone;
    object.gone = now;
    revisions.push_back(std::move(object));
    objects_.erase(objects_.begin() + static_cast<std::ptrdiff_t>(k));
    this_pass_.erase(this_pass_.begin() + static_cast<std::ptrdiff_t>(k));
  }
  return revisions;
}

}  // namespace kawara::vision
