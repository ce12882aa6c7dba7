#pragma once
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/changed_object.hpp"
#include "core/time.hpp"
#include "vision/change/align_reference.hpp"
#include "vision/change/change_finder.hpp"
#include "vision/change/object_tracker.hpp"

namespace kawara::vision {

struct WatchOptions {
  FinderOptions finder = {};
  TrackerOptions tracker = {};
  AlignOptions alignment = {};
  bool align = true;
  double step_m = 0.5;        ///< of the drive between two looks
  double align_step_m = 4.0;  ///< and between two comparisons with the reference
  /// A thing is told of when it exists with this probability, and was found in so many looks.
  double min_existence = 0.9;
  int min_looks = 2;
  /// What is farther from the robot than this is left behind: nothing more will be learnt of it.
  double reach_m = 8.0;
};

/// What a look tells that was not known before.
struct ChangeNews {
  std::vector<core::ChangedObject> revisions;
  std::vector<core::RoadStation> stations;  ///< measured for the first time, or anew
  /// Objects of this pass that have been left behind, newest revisions: once each.
  std::vector<core::ChangedObject> settled;
  std::optional<Alignment> alignment;  ///< if it was measured at this look
  std::string trouble;  ///< the map does not fit the reference: nothing is subtracted
};

/// The 3rd update while driving: looks at what stands on the road about the robot as the votes come
/// in, so that a thing is told of before the robot has passed it, bettered while it is in reach,
/// and left as it is when its voxels have gone from memory. Nothing of it depends on how long the
/// drive is but the lists of objects and stations. Pure: the same maps give the same news. One
/// thread.
class ChangeWatch {
 public:
  ChangeWatch(KnownPlace place, const WatchOptions& options);

  /// See ObjectTracker::TakeUp.
  void TakeUp(std::vector<core::ChangedObject> known, bool this_pass) {
    tracker_.TakeUp(std::move(known), this_pass);
  }
  /// Whether the robot has come far enough for a look to be worth it.
  bool IsDue(const Eigen::Vector3d& here) const;
  /// A look from where the robot is, at voxels in memory, which are all there are within `known_m`
  /// of it.
  ChangeNews Look(const VoxelMap& map, const Eigen::Vector3d& here, double known_m,
                  core::UtcTime now);
  /// At the end of the drive: what was not settled yet.
  std::vector<core::ChangedObject> Settle();

  /// See ObjectTracker::Reissue.
  std::optional<core::ChangedObject> Reissue(const std::string& uid) {
    return tracker_.Reissue(uid);
  }
  const std::vector<core::ChangedObject>& objects() const { return tracker_.objects(); }
  const KnownPlace& place() const { return place_; }

 private:
  /// False: the map does not fit.
  bool Align(const VoxelMap& map, const Eigen::Vector3d& here, ChangeNews& news);
  /// What reaches the limit of sight may go on beyond: says so in its deviations.
  void DoubtOpenEnds(Findings& findings, const Eigen::Vector3d& here);
  void KeepSure(Findings& findings, const Eigen::Vector3d& here, double known_m);
  void AddStations(const Findings& findings, const Eigen::Vector3d& here, double known_m,
                   core::UtcTime now, ChangeNews& news);
  void AddSettled(const Eigen::Vector3d& here, ChangeNews& news);

  /// A thing that was found but not yet told of.
  struct Candidate {
    core::UprightBox box;
    int looks = 0;
  };

  KnownPlace place_;
  WatchOptions options_;
  ObjectTracker tracker_;
  bool own_ground_;  ///< the reference has none
  std::optional<Eigen::Vector3d> last_look_, last_alignment_;
  Eigen::Isometry3d reference_from_map_ = Eigen::Isometry3d::Identity();
  bool fits_ = true;
  std::vector<Candidate> candidates_;
  std::map<std::pair<std::string, std::int64_t>, core::RoadStation> told_stations_;  ///< by place
  std::set<std::string> open_;                ///< uids of this pass that are not settled
  std::set<std::string> whole_;               ///< and of those whose end has been seen
  std::vector<core::UprightBox> last_boxes_;  ///< of the last look
};

}  // namespace kawara::vision
