#include "comms/convert.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace kawara::comms {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void Put(const Vector3d& v, double (&out)[3]) { std::ranges::copy(v, out); }
Vector3d VectorFrom(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

// Row by row; covariances are symmetric, but not every matrix is.
void Put(const Matrix3d& m, double (&out)[9]) {
  for (int i = 0; i < 9; ++i) out[i] = m(i / 3, i % 3);
}
Matrix3d MatrixFrom(const double (&v)[9]) {
  Matrix3d m;
  for (int i = 0; i < 9; ++i) m(i / 3, i % 3) = v[i];
  return m;
}

bool IsRtkState(std::int8_t state) {
  return state >= 0 && state <= static_cast<std::int8_t>(core::RtkState::kDeadReckoning);
}
bool IsOnTheGlobe(double lat_deg, double lon_deg, double h_m) {
  return std::abs(lat_deg) <= 90.0 && std::abs(lon_deg) <= 360.0 &&
         std::abs(h_m) <= 1e6;  // false for NaN
}
bool AllFinite(const double* values, int n) {
  return std::all_of(values, values + n, [](double v) { return std::isfinite(v); });
}
core::Geodetic GeodeticFrom(double lat_deg, double lon_deg, double h_m) {
  return {lat_deg * core::kRadFromDeg, lon_deg * core::kRadFromDeg, h_m};
}
tl::unexpected<core::Error> Bad(const char* type, const char* what) {
  return core::Fail(core::ErrorCode::kFormat, std::string(type) + ": " + what);
}

}  // namespace

gnss_fix_t ToMessage(const core::GnssFix& fix) {
  gnss_fix_t m{};
  m.gps_ns = fix.time.ns();
  m.arrival_mono_ns = fix.arrival.ns();
  m.rtk_state = static_cast<std::int8_t>(fix.rtk);
  m.native_quality = static_cast<std::int8_t>(fix.native_quality);
  m.has_position = fix.has_position;
  m.covariance_from_receiver = fix.covariance_from_receiver;
  m.has_velocity = fix.has_velocity;
  m.has_heading = fix.has_heading;
  m.lat_deg = fix.antenna.lat_rad * core::kDegFromRad;
  m.lon_deg = fix.antenna.lon_rad * core::kDegFromRad;
  m.h_ellipsoidal_m = fix.antenna.h_ellipsoidal_m;
  Put(fix.position_cov_enu_m2, m.position_cov_enu_m2);
  Put(fix.velocity_enu_mps, m.velocity_enu_mps);
  Put(fix.velocity_sd_enu_mps, m.velocity_sd_enu_mps);
  m.geoid_separation_m = fix.geoid_separation_m;
  m.hdop = fix.hdop;
  m.correction_age_s = fix.correction_age_s;
  m.latency_s = fix.latency_s;
  m.heading_deg = fix.heading_rad * core::kDegFromRad;
  m.satellites = static_cast<std::int16_t>(fix.satellites);
  m.base_station = static_cast<std::int16_t>(fix.base_station);
  return m;
}

core::Expected<core::GnssFix> FromMessage(const gnss_fix_t& m) {
  if (!IsRtkState(m.rtk_state)) return Bad("gnss_fix_t", "no such RTK state");
  const bool finite = AllFinite(m.position_cov_enu_m2, 9);
  if (m.has_position != 0 && !(finite && IsOnTheGlobe(m.lat_deg, m.lon_deg, m.h_ellipsoidal_m))) {
    return Bad("gnss_fix_t", "position or covariance is not a number on the globe");
  }
  core::GnssFix fix;
  fix.time = core::GpsTime::FromNs(m.gps_ns);
  fix.arrival = core::MonoTime::FromNs(m.arrival_mono_ns);
  fix.rtk = static_cast<core::RtkState>(m.rtk_state);
  fix.native_quality = static_cast<std::uint8_t>(m.native_quality);
  fix.has_position = m.has_position != 0;
  fix.covariance_from_receiver = m.covariance_from_receiver != 0;
  fix.has_velocity = m.has_velocity != 0;
  fix.has_heading = m.has_heading != 0;
  fix.antenna = GeodeticFrom(m.lat_deg, m.lon_deg, m.h_ellipsoidal_m);
  fix.position_cov_enu_m2 = MatrixFrom(m.position_cov_enu_m2);
  fix.velocity_enu_mps = VectorFrom(m.velocity_enu_mps);
  fix.velocity_sd_enu_mps = VectorFrom(m.velocity_sd_enu_mps);
  fix.geoid_separation_m = m.geoid_separation_m;
  fix.hdop = m.hdop;
  fix.correction_age_s = m.correction_age_s;
  fix.latency_s = m.latency_s;
  fix.heading_rad = m.heading_deg * core::kRadFromDeg;
  fix.satellites = static_cast<std::uint16_t>(m.satellites);
  fix.base_station = static_cast<std::uint16_t>(m.base_station);
  return fix;
}

ahrs_sample_t ToMessage(const core::AhrsSample& sample, core::GpsTime sampled_gps) {
  ahrs_sample_t m{};
  m.arrival_mono_ns = sample.arrival.ns();
  m.sampled_mono_ns = sample.sampled.ns();
  m.gps_ns = sampled_gps.ns();
  m.has_attitude = sample.has_attitude;
  m.roll_deg = sample.attitude.roll_rad * core::kDegFromRad;
  m.pitch_deg = sample.attitude.pitch_rad * core::kDegFromRad;
  m.heading_magnetic_deg = sample.attitude.yaw_rad * core::kDegFromRad;
  Put(sample.rate_radps, m.rate_radps);
  Put(sample.specific_force_mps2, m.specific_force_mps2);
  Put(sample.magnetic_gauss, m.magnetic_gauss);
  m.temperature_degc = sample.temperature_degc;
  m.counter = sample.counter;
  return m;
}

core::Expected<core::AhrsSample> FromMessage(const ahrs_sample_t& m) {
  if (!AllFinite(m.rate_radps, 3) || !AllFinite(m.specific_force_mps2, 3)) {
    return Bad("ahrs_sample_t", "rate or specific force is not a number");
  }
  core::AhrsSample sample;
  sample.arrival = core::MonoTime::FromNs(m.arrival_mono_ns);
  sample.sampled = core::MonoTime::FromNs(m.sampled_mono_ns);
  sample.has_attitude = m.has_attitude != 0;
  sample.attitude = {m.roll_deg * core::kRadFromDeg, m.pitch_deg * core::kRadFromDeg,
                     m.heading_magnetic_deg * core::kRadFromDeg};
  sample.rate_radps = VectorFrom(m.rate_radps);
  sample.specific_force_mps2 = VectorFrom(m.specific_force_mps2);
  sample.magnetic_gauss = VectorFrom(m.magnetic_gauss);
  sample.temperature_degc = m.temperature_degc;
  sample.counter = static_cast<std::uint16_t>(m.counter);
  return sample;
}

pose_t ToMessage(const core::Pose& pose) {
  pose_t m{};
  m.gps_ns = pose.time.ns();
  m.mono_ns = pose.mono.ns();
  m.valid = pose.valid;
  m.rtk_state = static_cast<std::int8_t>(pose.rtk);
  m.lat_deg = pose.position.lat_rad * core::kDegFromRad;
  m.lon_deg = pose.position.lon_rad * core::kDegFromRad;
  m.h_ellipsoidal_m = pose.position.h_ellipsoidal_m;
  m.roll_deg = pose.attitude.roll_rad * core::kDegFromRad;
  m.pitch_deg = pose.attitude.pitch_rad * core::kDegFromRad;
  m.yaw_deg = pose.attitude.yaw_rad * core::kDegFromRad;
  Put(pose.velocity_enu_mps, m.velocity_enu_mps);
  Put(pose.position_cov_enu_m2, m.position_cov_enu_m2);
  Put(Vector3d(pose.attitude_sd_rad * core::kDegFromRad), m.attitude_sd_deg);
  m.gnss_age_s = pose.gnss_age_s;
  return m;
}

core::Expected<core::Pose> FromMessage(const pose_t& m) {
  if (!IsRtkState(m.rtk_state)) return Bad("pose_t", "no such RTK state");
  const double attitude[3] = {m.roll_deg, m.pitch_deg, m.yaw_deg};
  const bool finite = AllFinite(attitude, 3) && AllFinite(m.position_cov_enu_m2, 9);
  if (m.valid != 0 && !(finite && IsOnTheGlobe(m.lat_deg, m.lon_deg, m.h_ellipsoidal_m))) {
    return Bad(
        "pose_t",
        "says it is valid, but position, attitude or covariance is not a number on the globe");
  }
  core::Pose pose;
  pose.time = core::GpsTime::FromNs(m.gps_ns);
  pose.mono = core::MonoTime::FromNs(m.mono_ns);
  pose.valid = m.valid != 0;
  pose.rtk = static_cast<core::RtkState>(m.rtk_state);
  pose.position = GeodeticFrom(m.lat_deg, m.lon_deg, m.h_ellipsoidal_m);
  pose.attitude = {m.roll_deg * core::kRadFromDeg, m.pitch_deg * core::kRadFromDeg,
                   m.yaw_deg * core::kRadFromDeg};
  pose.velocity_enu_mps = VectorFrom(m.velocity_enu_mps);
  pose.position_cov_enu_m2 = MatrixFrom(m.position_cov_enu_m2);
  pose.attitude_sd_rad = VectorFrom(m.attitude_sd_deg) * core::kRadFromDeg;
  pose.gnss_age_s = m.gnss_age_s;
  return pose;
}

clock_t ToMessage(const estimation::ClockStatus& status, std::string_view stream) {
  clock_t m{};
  m.stream = std::string(stream);
  m.mono_ns = status.mono.ns();
  m.gps_ns = status.stream.ns();
  m.skew_ppm = status.skew_ppm;
  m.sigma_s = status.sigma_s;
  m.source = static_cast<std::int32_t>(status.source);
  m.steps = status.steps;
  m.outliers = status.outliers;
  return m;
}

core::Expected<estimation::ClockStatus> FromMessage(const clock_t& m) {
  if (m.source < 0 || m.source > 4) return Bad("clock_t", "no such source");
  estimation::ClockStatus status;
  status.mono = core::MonoTime::FromNs(m.mono_ns);
  status.stream = estimation::StreamTime::FromNs(m.gps_ns);
  status.skew_ppm = m.skew_ppm;
  status.sigma_s = m.sigma_s;
  status.source = static_cast<estimation::ClockSource>(m.source);
  status.steps = m.steps;
  status.outliers = m.outliers;
  return status;
}

navigation_t ToMessage(const estimation::NavigationReport& report) {
  navigation_t m{};
  m.gps_ns = report.time.ns();
  m.mono_ns = report.mono.ns();
  m.state = static_cast<std::int8_t>(report.state);
  m.reason = static_cast<std::int8_t>(report.reason);
  m.text = std::string(ToString(report.state)) + ", " + ToString(report.reason);
  for (int i = 0; i < 3; ++i) {
    m.position_sd_ned_m[i] = report.position_sd_ned_m(i);
    m.velocity_sd_ned_mps[i] = report.velocity_sd_ned_mps(i);
    m.attitude_sd_deg[i] = report.attitude_sd_rad(i) * core::kDegFromRad;
  }
  m.gnss_age_s = report.gnss_age_s;
  m.time_offset_s = report.time_offset_s;
  m.time_offset_sd_s = report.time_offset_sd_s;
  m.fixes_used = report.fixes_used;
  m.fixes_refused = report.fixes_refused;
  m.wrong_fix_episodes = report.wrong_fix_episodes;
  m.resets = report.resets;
  return m;
}

}  // namespace kawara::comms
