#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/expected.hpp"
#include "estimation/filter_tape.hpp"
#include "estimation/navigation_config.hpp"
#include "estimation/navigator.hpp"
#include "tools/navigate/aids.hpp"
#include "tools/navigate/plot_data.hpp"
#include "tools/navigate/reference_errors.hpp"
#include "tools/navigate/run_summary.hpp"
#include "tools/navigate/trajectory.hpp"

namespace kawara::navigate {

struct RunOptions {
  estimation::NavigationConfig navigation;
  bool at_antenna = false;  ///< the trajectory is the antenna's instead of the IMU's
  bool smooth = false;      ///< the trajectory is the smoothed one
  bool plot = false;        ///< collect what the report draws
};

/// Samples through the navigator, what it says into the trajectory, compared with the references.
/// A row is written when its inertial sample has been processed, as a robot would have known it,
/// and never again; with `smooth` they all come at the end. One thread.
class NavigationRun {
 public:
  /// `trajectory` and `references` (ascending by time) must outlive this.
  NavigationRun(const RunOptions& options, const std::vector<Reference>& references,
                TrajectoryFile& trajectory);

  /// Errors: those of writing.
  core::Expected<void> AddImu(const estimation::ImuSample& sample);
  void AddAid(const Aid& aid);
  /// Smooths if asked to. Errors: those of writing.
  core::Expected<void> Finish();

  /// After Finish().
  const PlotData& plot() const { return plot_; }
  const ReferenceErrors& errors() const { return errors_; }
  const ReferenceErrors* smoothed_errors() const { return smoothed_ ? &*smoothed_ : nullptr; }
  /// What the run itself knows of the summary.
  RunSummary Summary() const;

 private:
  estimation::NavSolution Wanted(const estimation::NavSolution& at_imu) const;
  core::Expected<void> FinishSmoothed();

  RunOptions options_;
  estimation::FilterTape tape_;
  estimation::Navigator navigator_;
  TrajectoryFile& trajectory_;
  ReferenceErrors errors_;
  std::optional<ReferenceErrors> smoothed_;
  PlotData plot_;
  std::optional<estimation::NavSolution> last_;  ///< the newest valid one that was written
  core::GpsTime first_imu_;
  core::GpsTime last_imu_;
  core::GpsTime first_valid_;
  core::Duration filter_time_{};
  core::Duration smoother_time_{};
  const std::vector<Reference>& references_;
};

}  // namespace kawara::navigate
