#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geodesy.hpp"
#include "tools/navigate/aids.hpp"
#include "tools/navigate/reference_errors.hpp"
#include "tools/navigate/trajectory.hpp"

namespace kawara::navigate {

/// A stretch of time in one state.
struct StateSpan {
  core::GpsTime begin;
  core::GpsTime end;
  estimation::NavState state = estimation::NavState::kNone;
  estimation::NavReason reason = estimation::NavReason::kNominal;
};

/// A GNSS position in the picture.
struct PlottedFix {
  core::GpsTime time;
  Eigen::Vector3d ned_m;
  core::RtkState rtk = core::RtkState::kNone;
  Reference::Role role = Reference::Role::kGiven;
  std::optional<Eigen::Vector3d> residual_ned_m;  ///< position minus solution, at the antenna
};

/// What the report draws: a run of any length thinned to so many points that a page holds them.
/// Every change of state is kept. One thread.
class PlotData {
 public:
  /// Ascending by time.
  void Add(const TrajectoryPoint& point);
  void AddReferences(const std::vector<Reference>& references, const ReferenceErrors& errors);

  bool empty() const { return points_.empty(); }
  const core::Geodetic& origin() const {
    return origin_;
  }  ///< of north, east, down: the first point
  const std::vector<TrajectoryPoint>& points() const { return points_; }
  const std::vector<StateSpan>& states() const { return states_; }
  const std::vector<PlottedFix>& fixes() const { return fixes_; }

 private:
  core::Geodetic origin_;
  std::vector<TrajectoryPoint> points_;
  std::size_t every_ = 1;  ///< how many points make one
  std::size_t seen_ = 0;
  std::vector<StateSpan> states_;
  std::vector<PlottedFix> fixes_;
};

}  // namespace kawara::navigate
