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
      plane_(std::make_shared<GeographicLib::LocalCartesian>(origin.lat_rad * kDegFromRad,
                                                             origin.lon_rad * kDegFromRad,
                                                             origin.h_ellipsoidal_m)) {}

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

Geodetic OffsetNed(const Geodetic& g, const Eigen::Vector3d& ned_m) {
  constexpr double kA = 6378137.0;
  constexpr double kE2 = 6.69437999014131699614e-3;
  const double s = std::sin(g.lat_rad);
  const double w2 = 1.0 - kE2 * s * s;
  const double prime_vertical = kA / std::sqrt(w2);
  const double meridian = prime_vertical * (1.0 - kE2) / w2;
  return {g.lat_rad + ned_m.x() / (meridian + g.h_ellipsoidal_m),
          WrapPi(g.lon_rad +
                 ned_m.y() / ((prime_vertical + g.h_ellipsoidal_m) * std::cos(g.lat_rad))),
          g.h_ellipsoidal_m - ned_m.z()};
}

Eigen::Matrix3d RotationNedFromBody(const Attitude& a) {
  return (Eigen::AngleAxisd(a.yaw_rad, Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(a.pitch_rad, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(a.roll_rad, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

Attitude AttitudeFromRotation(const Eigen::Matrix3d& R) {
  const double s = std::clamp(-R(2, 0), -1.0, 1.0);
  return {std::atan2(R(2, 1), R(2, 2)), std::asin(s), std::atan2(R(1, 0), R(0, 0))};
}

double WrapPi(double angle_rad) {
  const double wrapped = std::remainder(angle_rad, 2.0 * kPi);
  return wrapped <= -kPi ? wrapped + 2.0 * kPi : wrapped;
}

}  // namespace kawara::core
