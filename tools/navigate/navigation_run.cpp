#include "tools/navigate/navigation_run.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimation/navigation_filter.hpp"
#include "estimation/smoother.hpp"

namespace kawara::navigate {
namespace {

/// Computing time of this thread so far: unlike the clock on the wall it does not count what other
/// programs on a busy machine take.
core::Duration ComputingTime() {
  timespec t{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return core::Seconds(t.tv_sec) + core::Nanoseconds(t.tv_nsec);
}

}  // namespace

NavigationRun::NavigationRun(const RunOptions& options, const std::vector<Reference>& references,
                             TrajectoryFile& trajectory)
    : options_(options),
      navigator_(options.navigation),
      trajectory_(trajectory),
      errors_(references, options.navigation.lever_arm_frd_m),
      references_(references) {
  if (options_.smooth) {
    navigator_.Record(&tape_);
    smoothed_.emplace(references, options.navigation.lever_arm_frd_m);
  }
}

estimation::NavSolution NavigationRun::Wanted(const estimation::NavSolution& at_imu) const {
  return options_.at_antenna ? estimation::MovedTo(at_imu, options_.navigation.lever_arm_frd_m)
                             : at_imu;
}

void NavigationRun::AddAid(const Aid& aid) {
  const core::Duration start = ComputingTime();
  if (const auto* fix = std::get_if<core::GnssFix>(&aid.data)) {
    navigator_.AddFix(*fix);
  } else if (const auto* odometry = std::get_if<estimation::OdometrySample>(&aid.data)) {
    navigator_.AddOdometry(*odometry);
  } else if (const auto* attitude = std::get_if<estimation::AttitudeSample>(&aid.data)) {
    navigator_.AddAttitude(*attitude);
  }
  filter_time_ += ComputingTime() - start;
}

core::Expected<void> NavigationRun::AddImu(const estimation::ImuSample& sample) {
  if (!first_imu_.IsSet()) first_imu_ = sample.time;
  last_imu_ = std::max(last_imu_, sample.time);
  const core::Duration start = ComputingTime();
  const bool fresh = navigator_.AddImu(sample);
  filter_time_ += ComputingTime() - start;
  const estimation::NavSolution& solution = navigator_.Latest();
  // The offset of the IMU's clock is being estimated and moves the stamps a little: never back.
  if (!fresh || !solution.valid() || (last_ && solution.time <= last_->time)) return {};
  if (last_) errors_.AddStretch(*last_, solution);
  if (!last_) first_valid_ = solution.time;
  last_ = solution;
  if (options_.smooth) return {};
  const TrajectoryPoint point = TrajectoryPoint::Of(Wanted(solution));
  if (options_.plot) plot_.Add(point);
  return trajectory_.Add(point);
}

core::Expected<void> NavigationRun::Finish() {
  if (options_.smooth) {
    if (auto ok = FinishSmoothed(); !ok) return ok;
  }
  if (options_.plot) plot_.AddReferences(references_, smoothed_ ? *smoothed_ : errors_);
  return {};
}

core::Expected<void> NavigationRun::FinishSmoothed() {
  std::vector<TrajectoryPoint> newest_first;
  std::optional<estimation::NavSolution> later;
  const core::Duration start = ComputingTime();
  estimation::Smooth(tape_, [&](const estimation::NavSolution& solution) {
    if (!solution.valid() || (later && solution.time >= later->time)) return true;
    if (later) smoothed_->AddStretch(solution, *later);
    later = solution;
    newest_first.push_back(TrajectoryPoint::Of(Wanted(solution)));
    return true;
  });
  smoother_time_ = ComputingTime() - start;
  for (auto point = newest_first.rbegin(); point != newest_first.rend(); ++point) {
    if (options_.plot) plot_.Add(*point);
    if (auto ok = trajectory_.Add(*point); !ok) return ok;
  }
  return {};
}

RunSummary NavigationRun::Summary() const {
  RunSummary summary;
  summary.stats = navigator_.stats();
  summary.imu_span_s = core::ToSeconds(last_imu_ - first_imu_);
  if (last_) summary.seconds_to_first_row = core::ToSeconds(first_valid_ - first_imu_);
  summary.rows = trajectory_.rows();
  summary.filter_s = core::ToSeconds(filter_time_);
  summary.smoother_s = core::ToSeconds(smoother_time_);
  const estimation::NavigationFilter* filter = navigator_.filter();
  if (filter == nullptr) return summary;
  const estimation::NominalState& state = filter->state();
  const estimation::ErrorCovariance& covariance = filter->errors().covariance();
  const auto found = [&](double value, estimation::ErrorIndex which, double unit) {
    return Found{value * unit, std::sqrt(covariance(which, which)) * unit};
  };
  const auto offset = filter->time_offset();
  CalibrationFound& c = summary.found.emplace();
  c.time_offset_s = {offset.value_s, offset.sd_s};
  c.speed_scale = found(state.speed_scale, estimation::kSpeedScale, 1.0);
  c.turn_scale = found(state.turn_scale, estimation::kTurnScale, 1.0);
  c.mount_pitch_deg = found(state.mount_pitch_rad, estimation::kMountPitch, core::kDegFromRad);
  c.mount_yaw_deg = found(state.mount_yaw_rad, estimation::kMountYaw, core::kDegFromRad);
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const auto gyro = static_cast<estimation::ErrorIndex>(estimation::kGyroBias + i);
    const auto accel = static_cast<estimation::ErrorIndex>(estimation::kAccelBias + i);
    c.gyro_bias_degps[at] = found(state.gyro_bias_radps[i], gyro, core::kDegFromRad);
    c.accel_bias_mps2[at] = found(state.accel_bias_mps2[i], accel, 1.0);
  }
  return summary;
}

}  // namespace kawara::navigate
