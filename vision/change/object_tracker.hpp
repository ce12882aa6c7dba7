#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/changed_object.hpp"
#include "vision/change/change_finder.hpp"

namespace kawara::vision {

struct TrackerOptions {
  std::string uid_prefix = "object";  ///< uids are PREFIX-1, PREFIX-2, ...
  std::string robot = {};             ///< who looks; empty: nobody in particular
  /// Uids that somebody else has given away, beside those taken up; may be empty.
  std::function<bool(const std::string& uid)> taken = {};
  /// Two looks are at one object if their boxes' centres are nearer than this share of the smaller
  /// one's length, or than the metres, or if so much of the smaller one's floor is shared.
  double same_share = 0.5, same_m = 0.75, same_floor = 0.4;
  double moved_m = 0.5;            ///< less is the same place
  double grown_share = 0.3;        ///< of the volume
  double moved_away_m = 15.0;      ///< how far a thing is looked for that has left its place
  double gone_ground_share = 0.5;  ///< of its floor that must be seen as bare ground
};

/// Objects over time and over passes: the same thing keeps its uid through all revisions; it is
/// moved, grown or gone by evidence only, and not seen is never gone. Several robots may feed the
/// same objects: TakeUp what the register knows. One thread.
class ObjectTracker {
 public:
  explicit ObjectTracker(const TrackerOptions& options) : options_(options) {}

  /// What is known from earlier passes or other robots, or from this pass before a restart. Of what
  /// is gone only the uid counts.
  void TakeUp(std::vector<core::ChangedObject> known, bool this_pass = false);
  /// A look at everything in reach at a time. `last_absent`: when the reference knew nothing there.
  /// Answers the revisions to be published: new objects, what has changed or is better known, and
  /// what is gone; what this pass took for a thing of its own and was a part of another is gone
  /// too.
  std::vector<core::ChangedObject> Update(const Findings& findings, core::UtcTime now,
                                          core::UtcTime last_absent);

  /// A new revision of an object that stands, with nothing new in it: for what hangs on it.
  /// Nothing: there is none.
  std::optional<core::ChangedObject> Reissue(const std::string& uid);

  /// Everything that stands, newest revisions.
  const std::vector<core::ChangedObject>& objects() const { return objects_; }

 private:
  bool Same(const core::UprightBox& a, const core::UprightBox& b) const;
  bool IsGone(const core::ChangedObject& object, const Findings& findings) const;
  bool IsPartOfAnother(std::size_t known, const std::vector<core::ChangedObject>& seen) const;
  /// The revision of a known object that a new look makes; false: nothing worth telling.
  bool Revise(core::ChangedObject& object, const core::ChangedObject& seen, bool this_pass,
              core::UtcTime now) const;
  std::string NextUid();
  std::uint64_t NumberOf(const std::string& uid) const;  ///< 0: not one of ours

  TrackerOptions options_;
  std::vector<core::ChangedObject> objects_;
  std::vector<bool> this_pass_;  ///< of objects_: found since the tracker was made
  std::uint64_t last_number_ = 0;
};

}  // namespace kawara::vision
