#include "onboard/navigation_chain.hpp"

#include <algorithm>

#include "estimation/local_frame.hpp"
#include "estimation/navigation_filter.hpp"

namespace kawara::onboard {
namespace {

estimation::PoseComposerConfig ComposerConfig(const OnboardConfig& config) {
  estimation::PoseComposerConfig composer;
  composer.lever_arm_frd_m = config.gps.antenna_frd_m;
  composer.heading.declination_rad = config.ahrs.magnetic_declination_deg * core::kRadFromDeg;
  return composer;
}

core::RtkState RtkOf(estimation::NavState state) {
  switch (state) {
    case estimation::NavState::kFixed:
      return core::RtkState::kFixed;
    case estimation::NavState::kFloat:
      return core::RtkState::kFloat;
    case estimation::NavState::kCode:
      return core::RtkState::kCodeDifferential;
    default:
      return core::RtkState::kDeadReckoning;
  }
}

}  // namespace

estimation::NavigationConfig FilterConfig(const OnboardConfig& config) {
  const NavigationSettings& settings = config.navigation;
  estimation::NavigationConfig filter;
  // The schema lets only known names through.
  filter.imu = estimation::WithFigures(
      estimation::FindSensorProfile(settings.sensor).value_or(estimation::ImuNoise{}),
      settings.imu);
  filter.lever_arm_frd_m = config.gps.antenna_frd_m;
  filter.constraint = settings.constraint == "off" ? estimation::ConstraintMode::kOff
                                                   : estimation::ConstraintMode::kAuto;
  filter.time_offset_sd_s = settings.time_offset_sd_s;
  filter.max_lateness = core::DurationFromSeconds(settings.max_lateness_s);
  return filter;
}

NavigationChain::NavigationChain(const OnboardConfig& config,
                                 const estimation::GpsTimeline& timeline, core::Events& events)
    : settings_(config.navigation),
      declination_rad_(config.ahrs.magnetic_declination_deg * core::kRadFromDeg),
      timeline_(timeline),
      events_(events),
      composer_(ComposerConfig(config)),
      navigator_(FilterConfig(config)) {}

void NavigationChain::AddFix(const core::GnssFix& fix) {
  composer_.AddFix(fix, timeline_);
  if (settings_.filter) navigator_.AddFix(fix);
}

core::Pose NavigationChain::AddAhrs(const core::AhrsSample& sample) {
  const core::Pose composed = composer_.AddAhrsAndCompose(sample, timeline_);
  if (!settings_.filter || !timeline_.valid()) return composed;
  const core::GpsTime time = timeline_.ToGps(sample.sampled).time;
  if (sample.has_attitude) {
    estimation::AttitudeSample attitude;
    attitude.time = time;
    attitude.has_level = true;
    attitude.has_heading = true;
    attitude.attitude = sample.attitude;
    attitude.attitude.yaw_rad = core::WrapPi(sample.attitude.yaw_rad + declination_rad_);
    navigator_.AddAttitude(attitude);
  }
  const bool fresh = navigator_.AddImu({time, sample.rate_radps, sample.specific_force_mps2});
  TellChanges(sample.arrival);
  const estimation::NavSolution& solution = navigator_.Latest();
  if (!fresh || !solution.valid()) return composed;
  return PoseOf(solution, timeline_.ToMono(solution.time).time);
}

core::Pose NavigationChain::At(core::MonoTime t) const {
  if (settings_.filter && timeline_.valid()) {
    const auto solution = navigator_.At(timeline_.ToGps(t).time);
    if (solution && solution->valid()) return PoseOf(*solution, t);
  }
  return composer_.At(t, timeline_);
}

core::Pose NavigationChain::PoseOf(const estimation::NavSolution& solution,
                                   core::MonoTime mono) const {
  core::Pose pose;
  pose.time = solution.time;
  pose.mono = mono;
  pose.position = solution.position;
  pose.attitude = solution.attitude;
  pose.velocity_enu_mps = estimation::EnuFromNed(solution.velocity_ned_mps);
  const Eigen::Matrix3d enu_from_ned = estimation::EnuFromNed();
  pose.position_cov_enu_m2 =
      enu_from_ned * solution.covariance.topLeftCorner<3, 3>() * enu_from_ned.transpose();
  // What the clock is off by moves the robot along its way.
  const double clock_s = timeline_.ToGps(mono).sigma_s;
  pose.position_cov_enu_m2 +=
      clock_s * clock_s * pose.velocity_enu_mps * pose.velocity_enu_mps.transpose();
  pose.attitude_sd_rad = solution.attitude_sd_rad();
  pose.rtk = RtkOf(solution.state);
  pose.gnss_age_s = solution.gnss_age_s;
  pose.valid = true;
  return pose;
}

void NavigationChain::TellChanges(core::MonoTime now) {
  using estimation::NavReason;
  using estimation::NavState;
  const estimation::NavSolution& solution = navigator_.Latest();
  const bool refusing =
      solution.reason == NavReason::kGnssRefused || solution.reason == NavReason::kProbation;
  if (refusing && !told_refusing_) {
    events_.WarnHigh(now, "nav.wrong_fix",
                     "the receiver's positions contradict the robot's motion: not believed");
  }
  told_refusing_ = refusing;
  const std::int64_t resets = navigator_.stats().resets;
  if (resets > told_resets_) {
    events_.WarnHigh(now, "nav.reset",
                     "positions contradicted the robot's motion for so long that they are believed "
                     "now: the solution jumped");
  }
  told_resets_ = resets;
  if (solution.state == told_) return;
  const bool worse = solution.state < told_ && solution.state != NavState::kFixed;
  core::EventText text(estimation::ToString(solution.state));
  text.Append(", ").Append(estimation::ToString(solution.reason));
  if (worse) {
    events_.WarnLow(now, "nav.state", text);
  } else {
    events_.Info(now, "nav.state", text);
  }
  told_ = solution.state;
  changed_ = true;
}

estimation::NavigationReport NavigationChain::Report(core::MonoTime now) const {
  const estimation::NavSolution& solution = navigator_.Latest();
  const estimation::NavigationStats& stats = navigator_.stats();
  estimation::NavigationReport report;
  report.time = solution.time;
  report.mono = now;
  report.state = solution.state;
  report.reason = solution.reason;
  report.position_sd_ned_m = solution.position_sd_ned_m();
  report.velocity_sd_ned_mps = solution.velocity_sd_ned_mps();
  report.attitude_sd_rad = solution.attitude_sd_rad();
  report.gnss_age_s = solution.gnss_age_s;
  if (const estimation::NavigationFilter* filter = navigator_.filter()) {
    report.time_offset_s = filter->time_offset().value_s;
    report.time_offset_sd_s = filter->time_offset().sd_s;
  }
  for (const auto source : {estimation::NavSource::kFixed, estimation::NavSource::kFloat,
                            estimation::NavSource::kCode}) {
    report.fixes_used += stats.source[static_cast<std::size_t>(source)].accepted;
    report.fixes_refused += stats.source[static_cast<std::size_t>(source)].rejected;
  }
  report.wrong_fix_episodes = stats.wrong_fix_episodes;
  report.resets = stats.resets;
  return report;
}

}  // namespace kawara::onboard
