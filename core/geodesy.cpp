#include "core/geodesy.hpp"

#include <Eigen/Geometry>
#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/LocalCartesian.hpp>
#include <algorithm>
#include <cmath>

namespace kawara::core {

Eigen::Vector3d EcefFromGeodetic(const Geodetic& g) {
  Eigen::Vector3d p;
  GeographicLib::Geocentric::WGS84().Forward(g.lat_rad * kDegFromRad, g.lon_rad * kDegFromRad,
                                             g.h_ellipsoidal_m, p.x(), p.y(), p.z());
  return p;
}

Geodetic GeodeticFromEcef(const Eigen::Vector3d& ecef_m) {
  double lat_deg = 0, lon_deg = 0, h = 0;
  GeographicLib::Geocentric::WGS84().Reverse(ecef_m.x(), ecef_m.y(), ecef_m.z(), lat_deg, lon_deg,
                                             h);
  return {lat_deg * kRadFromDeg, lon_deg * kRadFromDeg, h};
}

LocalEnu::LocalEnu(const Geodetic& origin)
    : origin_(origin),
      plane_(std::make_shared<GeographicLib::LocalCartesian>(
          origin.lat_rad * kDegFromRad, origin.lon_rad * kDegFromRad, origin.h_ellipsoidal_m)) {}

Eigen::Vector3d LocalEnu::FromGeodetic(const Geodetic& g) const {
  Eigen::Vector3d p;
  plane_->Forward(g.lat_rad * kDegFromRad, g.lon_rad * kDegFromRad, g.h_ellipsoidal_m, p.x(), p.y(),
                  p.z());
  return p;
}

Geodetic LocalEnu::ToGeodetic(const Eigen::Vector3d& enu_m) const {
  double lat_deg = 0, lon_deg = 0, h = 0;
  plane_->Reverse(enu_m.x(), enu_m.y(), enu_m.z(), lat_deg, lon_deg, h);
  return {lat_deg * kRadFromDeg, lon_deg * kRadFromDeg, h};
}

namespace {

/// Columns: north, east, down at g, in earth-centred axes.
Eigen::Matrix3d RotationEcefFromNed(const Geodetic& g) {
  const double sin_lat = std::sin(g.lat_rad), cos_lat = std::cos(g.lat_rad);
  const double sin_lon = std::sin(g.lon_rad), cos_lon = std::cos(g.lon_rad);
  Eigen::Matrix3d R;
  R << -sin_lat * cos_lon, -sin_lon, -cos_lat * cos_lon,  //
      -sin_lat * sin_lon, cos_lon, -cos_lat * sin_lon,    //
      cos_lat, 0.0, -sin_lat;
  return R;
}

}  // namespace

// Through earth-centred coordinates: exact, and indifferent to poles and antimeridian, where the
// usual division by the radii of curvature is neither (4 cm in 100 m at 89 degrees).
Geodetic OffsetNed(const Geodetic& g, const Eigen::Vector3d& ned_m) {
  if (ned_m.isZero(0.0)) return g;
  Geodetic moved = GeodeticFromEcef(EcefFromGeodetic(g) + RotationEcefFromNed(g) * ned_m);
  moved.lon_rad = WrapPi(moved.lon_rad);
  return moved;
}

Eigen::Vector3d NedBetween(const Geodetic& from, const Geodetic& to) {
  return RotationEcefFromNed(from).transpose() * (EcefFromGeodetic(to) - EcefFromGeodetic(from));
}

Eigen::Matrix3d RotationNedFromBody(const Attitude& a) {
  return (Eigen::AngleAxisd(a.yaw_rad, Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(a.pitch_rad, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(a.roll_rad, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

Eigen::Matrix3d RotationEnuFromNed(const Geodetic& origin, const Geodetic& place) {
  const auto ecef_from_enu = [](const Geodetic& g) {
    const double sl = std::sin(g.lon_rad), cl = std::cos(g.lon_rad);
    const double sp = std::sin(g.lat_rad), cp = std::cos(g.lat_rad);
    Eigen::Matrix3d R;
    R << -sl, -sp * cl, cp * cl, cl, -sp * sl, cp * sl, 0.0, cp, sp;
    return R;
  };
  Eigen::Matrix3d R_enu_ned;
  R_enu_ned << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  return ecef_from_enu(origin).transpose() * ecef_from_enu(place) * R_enu_ned;
}

Attitude AttitudeFromRotation(const Eigen::Matrix3d& R) {
  const double cos_pitch = std::hypot(R(2, 1), R(2, 2));
  const double pitch = std::atan2(-R(2, 0), cos_pitch);
  // Looking straight up or down only the sum or difference of roll and yaw exists: all of it is
  // called yaw.
  if (cos_pitch < 1e-9) return {0.0, pitch, WrapPi(std::atan2(-R(0, 1), R(1, 1)))};
  return {WrapPi(std::atan2(R(2, 1), R(2, 2))), pitch, WrapPi(std::atan2(R(1, 0), R(0, 0)))};
}

double WrapPi(double angle_rad) {
  const double wrapped = std::remainder(angle_rad, 2.0 * kPi);
  return wrapped <= -kPi ? wrapped + 2.0 * kPi : wrapped;
}

}  // namespace kawara::core
