#pragma once
#include <cstdint>
#include <utility>

#include "core/events.hpp"
#include "core/measurements.hpp"
#include "estimation/gps_timeline.hpp"
#include "estimation/navigation_report.hpp"
#include "estimation/navigator.hpp"
#include "estimation/pose_composer.hpp"
#include "onboard/config.hpp"

namespace kawara::onboard {

/// What a robot's configuration means to the filter.
estimation::NavigationConfig FilterConfig(const OnboardConfig& config);

/// From fixes and attitude samples to the robot's pose: the RTK-GPS/INS filter as soon as it knows
/// its heading, before that (or if the configuration wants no filter) the pose composed of fix and
/// attitude unit. Tells of every change in how far the solution is to be trusted. Real-time safe
/// after construction; one thread; a pure function of its calls.
class NavigationChain {
 public:
  NavigationChain(const OnboardConfig& config, const estimation::GpsTimeline& timeline,
                  core::Events& events);

  void AddFix(const core::GnssFix& fix);
  /// The pose at that sample: the real-time output at the unit's rate.
  core::Pose AddAhrs(const core::AhrsSample& sample);
  /// Any instant of the last half second (of the composer's memory before the filter runs).
  core::Pose At(core::MonoTime t) const;

  /// Of the filter; kNone state while there is none.
  const estimation::NavSolution& solution() const { return navigator_.Latest(); }
  const estimation::Navigator& navigator() const { return navigator_; }
  bool has_filter() const { return settings_.filter; }
  estimation::NavigationReport Report(core::MonoTime now) const;
  /// The state is another since the last call.
  bool TakeChange() { return std::exchange(changed_, false); }

 private:
  core::Pose PoseOf(const estimation::NavSolution& solution, core::MonoTime mono) const;
  void TellChanges(core::MonoTime now);

  const NavigationSettings settings_;
  const double declination_rad_;
  const estimation::GpsTimeline& timeline_;
  core::Events& events_;
  estimation::PoseComposer composer_;
  estimation::Navigator navigator_;
  estimation::NavState told_ = estimation::NavState::kNone;
  bool told_refusing_ = false;
  std::int64_t told_resets_ = 0;
  bool changed_ = false;
};

}  // namespace kawara::onboard
