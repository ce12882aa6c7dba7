#include "estimation/pose_composer.hpp"

#include <algorithm>
#include <cmath>

#include "estimation/local_frame.hpp"

namespace kawara::estimation {
namespace {

/// Errors of course last about this long; see HeadingTracker::AddCourse.
constexpr core::Duration kCourseInterval = core::Milliseconds(900);
/// Without two-antenna accuracy from the receiver.
constexpr double kTwoAntennaSigmaRad = 0.5 * core::kRadFromDeg;
/// Fixes (samples) from the past in a row before the past is believed: the receiver was reset.
constexpr int kMaxTooLate = 5;
constexpr int kMaxBackwards = 50;

double Square(double v) { return v * v; }

bool IsUsable(const core::GnssFix& fix) {
  return fix.has_position && fix.time.ns() > 0 && std::isfinite(fix.antenna.lat_rad) &&
         std::isfinite(fix.antenna.lon_rad) && std::isfinite(fix.antenna.h_ellipsoidal_m) &&
         std::abs(fix.antenna.lat_rad) <= core::kPi / 2.0 && fix.position_cov_enu_m2.allFinite();
}

/// Rate of yaw [rad/s] of a body turning at w (FRD) in this attitude.
double YawRate(const core::Attitude& a, const Eigen::Vector3d& w) {
  const double cos_pitch = std::max(0.05, std::cos(a.pitch_rad));
  return (w.y() * std::sin(a.roll_rad) + w.z() * std::cos(a.roll_rad)) / cos_pitch;
}

}  // namespace

PoseComposer::PoseComposer(const PoseComposerConfig& config)
    : config_(config), heading_(config.heading) {}

void PoseComposer::AddFix(const core::GnssFix& fix, const GpsTimeline& clock) {
  if (!IsUsable(fix)) {
    ++stats_.fixes_empty;
    return;
  }
  const bool late = !fixes_.empty() && fix.time < fixes_.back().time;
  if (late && fixes_.back().time - fix.time > config_.max_lateness) {
    ++stats_.fixes_too_late;
    if (++too_late_in_row_ < kMaxTooLate) return;
    fixes_.Clear();
    last_course_ = {};
  }
  too_late_in_row_ = 0;
  if (!fixes_.Insert(fix)) {
    ++stats_.fixes_repeated;
    return;
  }
  ++stats_.fixes;
  if (late) ++stats_.fixes_late_inserted;
  if (!late) UpdateHeading(fix, clock);
}

void PoseComposer::UpdateHeading(const core::GnssFix& fix, const GpsTimeline& clock) {
  if (!clock.valid()) return;
  const AttitudeAt at = AttitudeOf(clock.ToMono(fix.time).time);
  if (!at.known) return;
  const core::Attitude attitude = core::AttitudeFromRotation(at.ned_body.toRotationMatrix());
  const double reference_yaw_rad = core::WrapPi(attitude.yaw_rad - heading_.offset_rad());
  if (fix.has_heading && std::isfinite(fix.heading_rad)) {
    heading_.AddHeading(reference_yaw_rad, fix.heading_rad, kTwoAntennaSigmaRad);
  }
  if (!fix.has_velocity || !fix.velocity_enu_mps.allFinite()) return;
  if (std::abs(YawRate(attitude, at.rate_radps)) > config_.heading.max_course_rate_radps) return;
  if (last_course_.IsSet() && fix.time - last_course_ < kCourseInterval) return;
  // The antenna on its mast sways; the course is that of the reference point.
  const Eigen::Vector3d sway_ned = at.ned_body * at.rate_radps.cross(config_.lever_arm_frd_m);
  const Eigen::Vector3d v_ned = NedFromEnu(fix.velocity_enu_mps) - sway_ned;
  const double speed_mps = v_ned.head<2>().norm();
  if (speed_mps < config_.heading.min_course_speed_mps) return;
  last_course_ = fix.time;
  heading_.AddCourse(reference_yaw_rad, std::atan2(v_ned.y(), v_ned.x()), speed_mps,
                     fix.velocity_sd_enu_mps.head<2>().maxCoeff());
}

void PoseComposer::AddAhrs(const core::AhrsSample& sample) {
  double elapsed_s = 0.0;
  if (!attitudes_.empty()) {
    const core::Duration since = sample.sampled - attitudes_.back().time;
    if (since.count() <= 0) {
      ++stats_.ahrs_out_of_order;
      if (++backwards_in_row_ < kMaxBackwards) return;
      attitudes_.Clear();
      heading_.LoseReference();
    } else {
      elapsed_s = core::ToSeconds(since);
    }
  }
  backwards_in_row_ = 0;
  ++stats_.ahrs;
  const core::Attitude unit = sample.has_attitude ? sample.attitude : core::Attitude{};
  const bool magnetic = sample.has_attitude && config_.heading.use_magnetic;
  if (magnetic) {
    reference_yaw_rad_ = core::WrapPi(unit.yaw_rad + config_.heading.declination_rad);
  } else if (elapsed_s > core::ToSeconds(config_.max_attitude_gap)) {
    heading_.LoseReference();
  } else if (!attitudes_.empty()) {
    const Eigen::Vector3d mean_rate = 0.5 * (sample.rate_radps + attitudes_.back().rate_radps);
    reference_yaw_rad_ = core::WrapPi(reference_yaw_rad_ + YawRate(unit, mean_rate) * elapsed_s);
  }
  heading_.Elapse(elapsed_s, magnetic);
  AttitudeSample kept;
  kept.time = sample.sampled;
  kept.ned_body = Eigen::Quaterniond(
      core::RotationNedFromBody({unit.roll_rad, unit.pitch_rad, reference_yaw_rad_}));
  kept.rate_radps = sample.rate_radps;
  kept.has_attitude = sample.has_attitude;
  attitudes_.Insert(kept);
}

core::Pose PoseComposer::AddAhrsAndCompose(const core::AhrsSample& sample,
                                           const GpsTimeline& clock) {
  AddAhrs(sample);
  return At(sample.sampled, clock);
}

core::Pose PoseComposer::At(core::MonoTime t, const GpsTimeline& clock) const {
  if (!clock.valid()) {
    core::Pose nowhere;
    nowhere.mono = t;
    nowhere.attitude_sd_rad.setConstant(core::kPi);
    return nowhere;
  }
  const Aligned<core::GpsTime> gps = clock.ToGps(t);
  return Compose(gps.time, t, gps.sigma_s, clock);
}

core::Pose PoseComposer::At(core::GpsTime t, const GpsTimeline& clock) const {
  const core::MonoTime mono = clock.valid() ? clock.ToMono(t).time : core::MonoTime{};
  return Compose(t, mono, 0.0, clock);
}

core::Pose PoseComposer::Compose(core::GpsTime gps, core::MonoTime mono, double time_sigma_s,
                                 const GpsTimeline& clock) const {
  core::Pose pose;
  pose.time = gps;
  pose.mono = mono;
  AttitudeAt attitude = AttitudeOf(mono);
  const PositionAt position = PositionOf(gps, clock);
  const Eigen::Vector3d& v = position.velocity_enu_mps;
  const double speed_mps = v.head<2>().norm();
  if (!attitude.known && position.known && speed_mps >= config_.heading.min_course_speed_mps) {
    // No attitude unit: level, and looking where it goes.
    const core::Attitude course{0.0, 0.0, std::atan2(v.x(), v.y())};
    attitude.ned_body = Eigen::Quaterniond(core::RotationNedFromBody(course));
    attitude.sigma_rad << config_.level_sigma_rad, config_.level_sigma_rad,
        2.0 * config_.heading.course_sigma_rad;
    attitude.rate_radps.setZero();
  }
  const Eigen::Matrix3d R_ned_body = attitude.ned_body.toRotationMatrix();
  pose.attitude = core::AttitudeFromRotation(R_ned_body);
  pose.attitude_sd_rad = attitude.sigma_rad;
  pose.gnss_age_s = position.age_s;
  pose.rtk = position.rtk;
  pose.valid = position.known;
  if (!position.known) return pose;

  const Eigen::Vector3d arm_ned_m = R_ned_body * config_.lever_arm_frd_m;
  const Eigen::Vector3d arm_velocity_ned =
      R_ned_body * attitude.rate_radps.cross(config_.lever_arm_frd_m);
  pose.position = core::OffsetNed(position.antenna, -arm_ned_m);
  pose.velocity_enu_mps = v - EnuFromNed(arm_velocity_ned);
  // A tilt of the arm: about north and east by the worse of roll and pitch, about down by the
  // heading.
  const double tilt = std::min(1.0, std::max(attitude.sigma_rad.x(), attitude.sigma_rad.y()));
  const Eigen::Vector3d turn(tilt, tilt, std::min(1.0, attitude.sigma_rad.z()));
  const Eigen::Matrix3d S = EnuFromNed() * CrossMatrix(arm_ned_m) * turn.asDiagonal();
  pose.position_cov_enu_m2 =
      position.cov_enu_m2 + S * S.transpose() +
      Square(time_sigma_s) * pose.velocity_enu_mps * pose.velocity_enu_mps.transpose();
  return pose;
}

}  // namespace kawara::estimation
