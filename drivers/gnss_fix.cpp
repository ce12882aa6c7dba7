#include "drivers/gnss_fix.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace kawara::drivers {
namespace {

using core::RtkState;

/// Where the receiver does not say: what the vertical velocity may be while it is taken as zero.
constexpr double kUnknownVerticalSdMps = 1.0;
/// Doppler velocity over open sky, and with fixed ambiguities.
constexpr double kVelocitySdMps = 0.1;
constexpr double kFixedVelocitySdMps = 0.05;
/// Below this speed a missing course is normal (the receiver cannot know it at rest).
constexpr double kCrawlMps = 0.5;
/// Correlations printed with three decimals may come out above one: kept below.
constexpr double kMaxCorrelation = 0.99;

bool Positive(double sigma) { return std::isfinite(sigma) && sigma > 0.0; }

core::Geodetic Position(double lat_deg, double lon_deg, double h_m) {
  return {lat_deg * core::kRadFromDeg, lon_deg * core::kRadFromDeg, h_m};
}

/// A cross term that the sigmas allow, else none.
double Cross(double covariance, double sd_a, double sd_b) {
  const double limit = kMaxCorrelation * sd_a * sd_b;
  return std::isfinite(covariance) && std::abs(covariance) <= limit ? covariance : 0.0;
}

Eigen::Matrix3d Diagonal(double east_sd, double north_sd, double up_sd) {
  return Eigen::Vector3d(east_sd * east_sd, north_sd * north_sd, up_sd * up_sd).asDiagonal();
}

void TakePosition(const EpochParts& p, ReceiverProfile profile, core::GnssFix& fix) {
  const auto take = [&](const core::Geodetic& position, RtkState state, int satellites) {
    fix.has_position = state != RtkState::kNone && std::isfinite(position.h_ellipsoidal_m);
    if (!fix.has_position) return false;
    fix.antenna = position;
    fix.rtk = state;
    fix.satellites = static_cast<std::uint16_t>(std::max(satellites, 0));
    return true;
  };
  if (p.cbn && p.cbn->has_position &&
      take(Position(p.cbn->lat_deg, p.cbn->lon_deg, p.cbn->h_ellipsoidal_m), RtkStateOfCbn(*p.cbn),
           p.cbn->satellites)) {
    return;
  }
  if (p.pos && p.pos->has_position &&
      take(Position(p.pos->lat_deg, p.pos->lon_deg, p.pos->height_m), RtkStateOfPos(p.pos->type),
           p.pos->satellites)) {
    return;
  }
  if (p.gga && p.gga->has_position &&
      take(Position(p.gga->lat_deg, p.gga->lon_deg, EllipsoidalHeight(*p.gga)),
           RtkStateOfGga(p.gga->quality, profile), p.gga->satellites)) {
    return;
  }
  if (p.pvt && take(Position(p.pvt->lat_deg, p.pvt->lon_deg, p.pvt->h_ellipsoidal_m),
                    RtkStateOfPvt(*p.pvt), p.pvt->satellites)) {
    return;
  }
  // Whether it was corrected is not said: the worse of the two.
  if (p.pbn && take(core::GeodeticFromEcef(p.pbn->ecef_m), RtkState::kAutonomous, 0)) return;
  if (p.gga) fix.satellites = static_cast<std::uint16_t>(std::max(p.gga->satellites, 0));
}

void TakeCovariance(const EpochParts& p, core::GnssFix& fix) {
  if (!fix.has_position) return;
  fix.covariance_from_receiver = true;
  if (p.cbn && Positive(p.cbn->lat_sd_m) && Positive(p.cbn->lon_sd_m) &&
      Positive(p.cbn->height_sd_m)) {
    const AshtechCbn& c = *p.cbn;
    Eigen::Matrix3d& cov = fix.position_cov_enu_m2;
    cov = Diagonal(c.lon_sd_m, c.lat_sd_m, c.height_sd_m);
    cov(0, 1) = cov(1, 0) = Cross(c.cross_m2[0], c.lat_sd_m, c.lon_sd_m);
    cov(1, 2) = cov(2, 1) = Cross(c.cross_m2[1], c.lat_sd_m, c.height_sd_m);
    cov(0, 2) = cov(2, 0) = Cross(c.cross_m2[2], c.lon_sd_m, c.height_sd_m);
    // Terms that are possible in pairs may be impossible together.
    if (cov.determinant() <= 0.0) cov = Diagonal(c.lon_sd_m, c.lat_sd_m, c.height_sd_m);
    return;
  }
  if (p.gst && Positive(p.gst->lat_sd_m) && Positive(p.gst->lon_sd_m) &&
      Positive(p.gst->alt_sd_m)) {
    const NmeaGst& g = *p.gst;
    fix.position_cov_enu_m2 = Diagonal(g.lon_sd_m, g.lat_sd_m, g.alt_sd_m);
    // The error ellipse gives the correlation of north and east that the sigmas alone do not.
    const double theta = g.orientation_deg * core::kRadFromDeg;
    const double cross = (g.semi_major_m * g.semi_major_m - g.semi_minor_m * g.semi_minor_m) *
                         std::sin(theta) * std::cos(theta);
    fix.position_cov_enu_m2(0, 1) = fix.position_cov_enu_m2(1, 0) =
        Cross(cross, g.lat_sd_m, g.lon_sd_m);
    return;
  }
  if (p.pvt && Positive(p.pvt->horizontal_sd_m) && Positive(p.pvt->vertical_sd_m)) {
    // u-blox states the radial error of the plane: a share for each of its two axes.
    const double axis_sd = p.pvt->horizontal_sd_m / std::sqrt(2.0);
    fix.position_cov_enu_m2 = Diagonal(axis_sd, axis_sd, p.pvt->vertical_sd_m);
    return;
  }
  fix.covariance_from_receiver = false;
  const HorizontalVertical sigma = PositionSigma(fix.rtk, fix.hdop);
  fix.position_cov_enu_m2 = Diagonal(sigma.horizontal_m, sigma.horizontal_m, sigma.vertical_m);
}

bool TakeCourseAndSpeed(double course_deg, double speed_mps, double up_mps, core::GnssFix& fix) {
  if (!std::isfinite(speed_mps)) return false;
  const bool has_course = std::isfinite(course_deg);
  if (!has_course && speed_mps > kCrawlMps) return false;
  const double course = has_course ? course_deg * core::kRadFromDeg : 0.0;
  const double along = has_course ? speed_mps : 0.0;
  const double sd = (fix.rtk == RtkState::kFixed ? kFixedVelocitySdMps : kVelocitySdMps) +
                    (has_course ? 0.0 : speed_mps);
  const bool has_up = std::isfinite(up_mps);
  fix.has_velocity = true;
  fix.velocity_enu_mps = {along * std::sin(course), along * std::cos(course),
                          has_up ? up_mps : 0.0};
  fix.velocity_sd_enu_mps = {sd, sd, has_up ? 2.0 * sd : kUnknownVerticalSdMps};
  return true;
}

void TakeVelocity(const EpochParts& p, ReceiverProfile profile, core::GnssFix& fix) {
  if (p.cbn && p.cbn->flags[0] != 0 && std::isfinite(p.cbn->east_mps) &&
      std::isfinite(p.cbn->north_mps) && std::isfinite(p.cbn->up_mps)) {
    const auto sd = [](double stated) { return Positive(stated) ? stated : kVelocitySdMps; };
    fix.has_velocity = true;
    fix.velocity_enu_mps = {p.cbn->east_mps, p.cbn->north_mps, p.cbn->up_mps};
    fix.velocity_sd_enu_mps = {sd(p.cbn->east_sd_mps), sd(p.cbn->north_sd_mps),
                               sd(p.cbn->up_sd_mps)};
    return;
  }
  if (p.pvt && RtkStateOfPvt(*p.pvt) != RtkState::kNone) {
    fix.has_velocity = true;
    fix.velocity_enu_mps = {p.pvt->east_mps, p.pvt->north_mps, -p.pvt->down_mps};
    const double sd = Positive(p.pvt->speed_sd_mps) ? p.pvt->speed_sd_mps : kVelocitySdMps;
    fix.velocity_sd_enu_mps = {sd, sd, sd};
    return;
  }
  if (p.pbn) {
    const core::Geodetic at = core::GeodeticFromEcef(p.pbn->ecef_m);
    const double sin_lat = std::sin(at.lat_rad);
    const double cos_lat = std::cos(at.lat_rad);
    const double sin_lon = std::sin(at.lon_rad);
    const double cos_lon = std::cos(at.lon_rad);
    Eigen::Matrix3d R_enu_ecef;
    R_enu_ecef << -sin_lon, cos_lon, 0.0,                 //
        -sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat,  //
        cos_lat * cos_lon, cos_lat * sin_lon, sin_lat;
    fix.has_velocity = true;
    fix.velocity_enu_mps = R_enu_ecef * p.pbn->velocity_ecef_mps;
    fix.velocity_sd_enu_mps = {kVelocitySdMps, kVelocitySdMps, 2.0 * kVelocitySdMps};
    return;
  }
  if (p.pos && p.pos->type >= 0) {
    const PosVelocity v = VelocityOfPos(*p.pos, profile);
    if (TakeCourseAndSpeed(p.pos->course_deg, v.speed_mps, v.up_mps, fix)) return;
  }
  if (p.rmc && p.rmc->valid &&
      TakeCourseAndSpeed(p.rmc->course_deg, p.rmc->speed_mps, kNotSaid, fix)) {
    return;
  }
  if (p.vtg && fix.rtk != RtkState::kNone && p.vtg->mode != 'N')
    TakeCourseAndSpeed(p.vtg->course_true_deg, p.vtg->speed_mps, kNotSaid, fix);
}

}  // namespace

HorizontalVertical PositionSigma(RtkState state, double hdop) {
  HorizontalVertical sigma;
  switch (state) {
    case RtkState::kFixed:
      sigma = {0.02, 0.04};
      break;
    case RtkState::kFloat:
      sigma = {0.4, 0.8};
      break;
    case RtkState::kCodeDifferential:
      sigma = {1.0, 2.0};
      break;
    case RtkState::kAutonomous:
      sigma = {3.0, 6.0};
      break;
    case RtkState::kDeadReckoning:
      sigma = {10.0, 10.0};
      break;
    case RtkState::kNone:
      sigma = {100.0, 100.0};
      break;
  }
  const double worse = std::isfinite(hdop) ? std::clamp(hdop, 1.0, 50.0) : 1.0;
  return {sigma.horizontal_m * worse, sigma.vertical_m * worse};
}

core::GnssFix MakeFix(const EpochParts& p, ReceiverProfile profile) {
  core::GnssFix fix;
  fix.geoid_separation_m = fix.hdop = fix.correction_age_s = fix.latency_s = kNotSaid;
  if (p.gga) {
    const AgeAndLatency age = AgeOfGga(*p.gga, profile);
    fix.native_quality = p.gga->quality;
    fix.geoid_separation_m = p.gga->geoid_separation_m;
    fix.hdop = p.gga->hdop;
    fix.correction_age_s = age.age_s;
    fix.latency_s = age.latency_s;
    if (p.gga->station >= 0) fix.base_station = static_cast<std::uint16_t>(p.gga->station);
  } else if (p.pos) {
    fix.native_quality = static_cast<std::uint8_t>(std::max(p.pos->type, 0));
  } else if (p.pvt) {
    fix.native_quality = p.pvt->carrier;
  }
  if (p.pos) {
    if (std::isnan(fix.hdop)) fix.hdop = p.pos->hdop;
    if (std::isnan(fix.correction_age_s)) fix.correction_age_s = p.pos->age_s;
  }
  if (p.latency) fix.latency_s = p.latency->latency_s;
  TakePosition(p, profile, fix);
  TakeCovariance(p, fix);
  TakeVelocity(p, profile, fix);
  // THS: only what was measured or estimated, nothing typed in or simulated. HDT has no mode.
  const bool measured =
      p.heading && (p.heading->mode == '\0' || p.heading->mode == 'A' || p.heading->mode == 'E');
  if (measured && std::isfinite(p.heading->true_heading_deg)) {
    fix.has_heading = true;
    fix.heading_rad = core::WrapPi(p.heading->true_heading_deg * core::kRadFromDeg);
  }
  return fix;
}

}  // namespace kawara::drivers
