#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "estimation/nav_types.hpp"
#include "tools/navigate/aids.hpp"

namespace kawara::navigate {

/// Root mean squares of a set of errors.
struct ErrorSum {
  std::int64_t count = 0;
  Eigen::Vector3d square_sum_m2 = Eigen::Vector3d::Zero();
  double worst_horizontal_m = 0.0;

  void Add(const Eigen::Vector3d& ned_m);
  Eigen::Vector3d RmsNed() const;  ///< NaN if there are none
};

/// The largest error in one window without GNSS.
struct WindowError {
  TimeWindow window;
  std::int64_t count = 0;  ///< RTK fixes to compare with
  double worst_horizontal_m = 0.0;
};

/// How far a solution is from GNSS positions it may or may not have seen, at the antenna. The
/// solution comes in as stretches between neighbours, in either direction of time.
class ReferenceErrors {
 public:
  /// `references` ascending by time; must outlive this.
  ReferenceErrors(const std::vector<Reference>& references, const Eigen::Vector3d& lever_frd_m);

  /// `earlier` and `later` follow each other. A stretch longer than a second (a gap) is left out,
  /// and so is one that is not valid.
  void AddStretch(const estimation::NavSolution& earlier, const estimation::NavSolution& later);

  /// Reference minus solution, north, east, down, at references()[i]; nothing where there was none.
  const std::optional<Eigen::Vector3d>& residual(std::size_t i) const { return residual_[i]; }

  ErrorSum HeldOut(core::RtkState rtk) const;
  std::int64_t held_out_uncovered() const;  ///< held-out epochs without a solution
  /// One for each window, judged by RTK fixed positions.
  std::vector<WindowError> Blanked(const std::vector<TimeWindow>& windows) const;

 private:
  const std::vector<Reference>& references_;
  Eigen::Vector3d lever_frd_m_;
  std::vector<std::optional<Eigen::Vector3d>> residual_;
};

/// Root mean square of the windows' largest errors, of those that have any.
double RmsOfWorst(const std::vector<WindowError>& windows);

}  // namespace kawara::navigate
