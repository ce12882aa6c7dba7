#include "onboard/survey/pose_motion.hpp"

#include <cmath>

namespace kawara::survey {
namespace {

/// Poses farther apart in time say nothing of the motion between them.
constexpr double kFarthest = 1.0;

}  // namespace

Eigen::Isometry3d PoseLater(const std::vector<PoseRow>& rows, std::size_t row, double seconds) {
  const PoseRow& here = rows[row];
  if (seconds == 0.0 || !here.time.IsSet()) return here.map_from_body;
  const PoseRow* before = &here;
  const PoseRow* after = &here;
  for (const PoseRow& other : rows) {
    if (!other.time.IsSet() || other.camera != here.camera) continue;
    const double gap = core::ToSeconds(other.time - here.time);
    if (std::abs(gap) > kFarthest) continue;
    if (gap < 0.0 && (before == &here || other.time > before->time)) before = &other;
    if (gap > 0.0 && (after == &here || other.time < after->time)) after = &other;
  }
  const double span = core::ToSeconds(after->time - before->time);
  if (span <= 0.0) return here.map_from_body;
  const Eigen::Isometry3d& from = before->map_from_body;
  const Eigen::Isometry3d& to = after->map_from_body;
  const Eigen::AngleAxisd turn(from.linear().transpose() * to.linear());
  Eigen::Isometry3d later = here.map_from_body;
  later.translation() += seconds / span * (to.translation() - from.translation());
  later.linear() = here.map_from_body.linear() *
                   Eigen::AngleAxisd(seconds / span * turn.angle(), turn.axis()).toRotationMatrix();
  return later;
}

}  // namespace kawara::survey
