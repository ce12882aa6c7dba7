#include "estimation/nav_types.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "estimation/error_state.hpp"
#include "estimation/local_frame.hpp"
#include "estimation/rotation.hpp"

namespace kawara::estimation {

const char* ToString(NavState state) {
  switch (state) {
    case NavState::kNone:
      return "none";
    case NavState::kAligning:
      return "aligning";
    case NavState::kInertial:
      return "inertial";
    case NavState::kDeadReckoning:
      return "dead-reckoning";
    case NavState::kCode:
      return "code";
    case NavState::kFloat:
      return "float";
    case NavState::kFixed:
      return "fixed";
  }
  return "?";
}

const char* ToString(NavReason reason) {
  switch (reason) {
    case NavReason::kNominal:
      return "nominal";
    case NavReason::kNoFixYet:
      return "no-fix-yet";
    case NavReason::kHeadingUnknown:
      return "heading-unknown";
    case NavReason::kNoGnss:
      return "no-gnss";
    case NavReason::kGnssRefused:
      return "gnss-refused";
    case NavReason::kProbation:
      return "probation";
    case NavReason::kReset:
      return "reset";
    case NavReason::kImuGap:
      return "imu-gap";
    case NavReason::kNotFixed:
      return "not-fixed";
  }
  return "?";
}

Eigen::Vector3d NavSolution::position_sd_ned_m() const {
  return covariance.diagonal().segment<3>(kPosition).cwiseMax(0.0).cwiseSqrt();
}

Eigen::Vector3d NavSolution::velocity_sd_ned_mps() const {
  return covariance.diagonal().segment<3>(kVelocity).cwiseMax(0.0).cwiseSqrt();
}

Eigen::Vector3d NavSolution::attitude_sd_rad() const {
  const Eigen::Matrix3d euler = EulerFromRotationVector(attitude);
  const Eigen::Matrix3d cov = covariance.block<3, 3>(kAttitude, kAttitude);
  return (euler * cov * euler.transpose()).diagonal().cwiseMax(0.0).cwiseSqrt();
}

NavSolution MovedTo(const NavSolution& solution, const Eigen::Vector3d& lever_frd_m) {
  const Eigen::Matrix3d ned_from_body = core::RotationNedFromBody(solution.attitude);
  const Eigen::Vector3d arm = ned_from_body * lever_frd_m;
  const Eigen::Vector3d sway = ned_from_body * solution.rate_frd_radps.cross(lever_frd_m);
  NavSolution moved = solution;
  moved.position = Displaced(solution.position, arm);
  moved.velocity_ned_mps += sway;
  NavCovariance jacobian = NavCovariance::Identity();
  jacobian.block<3, 3>(kPosition, kAttitude) = -CrossMatrix(arm);
  jacobian.block<3, 3>(kVelocity, kAttitude) = -CrossMatrix(sway);
  moved.covariance = jacobian * solution.covariance * jacobian.transpose();
  return moved;
}

NavSolution Interpolated(const NavSolution& before, const NavSolution& after, core::GpsTime t) {
  const double span_s = core::ToSeconds(after.time - before.time);
  const double dt_s = core::ToSeconds(t - before.time);
  if (span_s <= 0.0 || dt_s <= 0.0 || dt_s >= span_s) {
    // Carried on by velocity and rate.
    const NavSolution& end = dt_s <= 0.0 ? before : after;
    const double ahead_s = core::ToSeconds(t - end.time);
    NavSolution out = end;
    out.time = t;
    out.position = Displaced(end.position, ahead_s * end.velocity_ned_mps);
    out.attitude =
        core::AttitudeFromRotation(core::RotationNedFromBody(end.attitude) *
                                   Rotation(end.rate_frd_radps * ahead_s).toRotationMatrix());
    return out;
  }
  const double u = dt_s / span_s;
  const Eigen::Vector3d way = Displacement(before.position, after.position);
  const double h_way = u * u * (3.0 - 2.0 * u);
  const double h_start = u * (1.0 - u) * (1.0 - u) * span_s;
  const double h_end = u * u * (u - 1.0) * span_s;
  NavSolution out = u < 0.5 ? before : after;
  out.time = t;
  out.position = Displaced(before.position, h_way * way + h_start * before.velocity_ned_mps +
                                                h_end * after.velocity_ned_mps);
  out.velocity_ned_mps = (1.0 - u) * before.velocity_ned_mps + u * after.velocity_ned_mps;
  out.rate_frd_radps = (1.0 - u) * before.rate_frd_radps + u * after.rate_frd_radps;
  const Eigen::Quaterniond from(core::RotationNedFromBody(before.attitude));
  const Eigen::Quaterniond to(core::RotationNedFromBody(after.attitude));
  out.attitude = core::AttitudeFromRotation(from.slerp(u, to).toRotationMatrix());
  out.covariance = (1.0 - u) * before.covariance + u * after.covariance;
  out.gnss_age_s = (1.0 - u) * before.gnss_age_s + u * after.gnss_age_s;
  return out;
}

}  // namespace kawara::estimation
