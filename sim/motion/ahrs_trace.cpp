#include "sim/motion/ahrs_trace.hpp"

#include <algorithm>
#include <cmath>

#include "sim/dice.hpp"

namespace kawara::sim {
namespace {

constexpr double kGravity_mps2 = 9.80665;
/// How long the gyro is believed against gravity and magnetic heading.
constexpr double kLevelTau_s = 10.0;
constexpr double kHeadingTau_s = 4.0;
/// Beyond this the vehicle is accelerating and the force does not point up.
constexpr double kQuietForce_mps2 = 0.5;
constexpr double kMagneticNoise_gauss = 0.0027;

Eigen::Vector3d FieldNed(const RecordingSite& site) {
  const double horizontal = site.field_gauss * std::cos(site.dip_rad);
  return {horizontal * std::cos(site.declination_rad), horizontal * std::sin(site.declination_rad),
          site.field_gauss * std::sin(site.dip_rad)};
}

/// Heading from the field with roll and pitch taken out.
double MagneticHeading(const Eigen::Vector3d& field_body, const core::Attitude& attitude) {
  const Eigen::Matrix3d R_level_body =
      core::RotationNedFromBody({attitude.roll_rad, attitude.pitch_rad, 0.0});
  const Eigen::Vector3d level = R_level_body * field_body;
  return std::atan2(-level.y(), level.x());
}

}  // namespace

void CoarseAttitudeFilter::Update(double dt_s, const AhrsState& sample) {
  const Eigen::Vector3d& f = sample.specific_force_mps2;
  const double roll_level = std::atan2(-f.y(), -f.z());
  const double pitch_level = std::atan2(f.x(), std::hypot(f.y(), f.z()));
  if (!started_) {
    started_ = true;
    attitude_ = {roll_level, pitch_level, 0.0};
    attitude_.yaw_rad = MagneticHeading(sample.magnetic_gauss, attitude_);
    return;
  }
  // Euler angle rates of ZYX; pitch of a ground vehicle stays far from 90 degrees.
  const Eigen::Vector3d& w = sample.rate_radps;
  const double sr = std::sin(attitude_.roll_rad);
  const double cr = std::cos(attitude_.roll_rad);
  const double turn = w.y() * sr + w.z() * cr;
  const double cos_pitch = std::max(std::cos(attitude_.pitch_rad), 0.1);
  attitude_.roll_rad +=
      dt_s * (w.x() + turn * std::tan(std::clamp(attitude_.pitch_rad, -1.4, 1.4)));
  attitude_.pitch_rad += dt_s * (w.y() * cr - w.z() * sr);
  attitude_.yaw_rad += dt_s * turn / cos_pitch;

  if (std::abs(f.norm() - kGravity_mps2) < kQuietForce_mps2) {
    const double gain = std::min(dt_s / kLevelTau_s, 1.0);
    attitude_.roll_rad += gain * core::WrapPi(roll_level - attitude_.roll_rad);
    attitude_.pitch_rad += gain * (pitch_level - attitude_.pitch_rad);
  }
  const double heading_error =
      MagneticHeading(sample.magnetic_gauss, attitude_) - attitude_.yaw_rad;
  attitude_.yaw_rad += std::min(dt_s / kHeadingTau_s, 1.0) * core::WrapPi(heading_error);
  attitude_.roll_rad = core::WrapPi(attitude_.roll_rad);
  attitude_.yaw_rad = core::WrapPi(attitude_.yaw_rad);
}

std::vector<AhrsState> MakeAhrsTrace(const Recording& recording, const MotionTrack& track,
                                     std::uint64_t seed) {
  std::vector<AhrsState> trace;
  trace.reserve(recording.imu.size());
  Dice dice(seed);
  CoarseAttitudeFilter filter;
  const Eigen::Vector3d field_ned = FieldNed(recording.site);
  const core::Duration late = core::DurationFromSeconds(recording.site.imu_late_s);
  for (const RecordedImu& sample : recording.imu) {
    AhrsState state;
    state.time = sample.time;
    state.rate_radps = sample.rate_radps;
    state.specific_force_mps2 = sample.specific_force_mps2;
    if (sample.magnetic_gauss) {
      state.magnetic_gauss = *sample.magnetic_gauss;
    } else {
      // The field belongs to the same instant as the gyro: the recorded stamp less its known
      // lateness.
      const core::Attitude body{filter.attitude().roll_rad, filter.attitude().pitch_rad,
                                track.YawAt(sample.time - late)};
      state.magnetic_gauss = core::RotationNedFromBody(body).transpose() * field_ned;
      for (double& axis : state.magnetic_gauss) axis += kMagneticNoise_gauss * dice.Normal();
    }
    const double dt_s = trace.empty() ? 0.0 : core::ToSeconds(sample.time - trace.back().time);
    filter.Update(std::min(dt_s, 1.0), state);
    state.attitude = filter.attitude();
    trace.push_back(state);
  }
  return trace;
}

}  // namespace kawara::sim
