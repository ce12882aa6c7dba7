#include "estimation/earth.hpp"

#include <cmath>

namespace kawara::estimation {
namespace {

constexpr double kSemiMajor = 6378137.0;
constexpr double kFlattening = 1.0 / 298.257223563;
constexpr double kEccentricity2 = kFlattening * (2.0 - kFlattening);
constexpr double kSemiMinor = kSemiMajor * (1.0 - kFlattening);
constexpr double kRotation = 7.292115e-5;
constexpr double kGm = 3.986004418e14;
constexpr double kGravityEquator = 9.7803253359;
constexpr double kSomigliana = 0.00193185265241;

}  // namespace

CurvatureRadii RadiiAt(double lat_rad) {
  const double s = std::sin(lat_rad);
  const double w2 = 1.0 - kEccentricity2 * s * s;
  const double w = std::sqrt(w2);
  return {kSemiMajor * (1.0 - kEccentricity2) / (w2 * w), kSemiMajor / w};
}

double NormalGravity(double lat_rad, double h_ellipsoidal_m) {
  const double s2 = std::sin(lat_rad) * std::sin(lat_rad);
  const double surface =
      kGravityEquator * (1.0 + kSomigliana * s2) / std::sqrt(1.0 - kEccentricity2 * s2);
  const double m = kRotation * kRotation * kSemiMajor * kSemiMajor * kSemiMinor / kGm;
  const double h = h_ellipsoidal_m / kSemiMajor;
  return surface * (1.0 - 2.0 * (1.0 + kFlattening + m - 2.0 * kFlattening * s2) * h + 3.0 * h * h);
}

Eigen::Vector3d EarthRateNed(double lat_rad) {
  return {kRotation * std::cos(lat_rad), 0.0, -kRotation * std::sin(lat_rad)};
}

Eigen::Vector3d TransportRateNed(double lat_rad, double h_ellipsoidal_m,
                                 const Eigen::Vector3d& velocity_ned_mps) {
  const auto radii = RadiiAt(lat_rad);
  const double east = velocity_ned_mps.y() / (radii.prime_vertical_m + h_ellipsoidal_m);
  const double north = velocity_ned_mps.x() / (radii.meridian_m + h_ellipsoidal_m);
  return {east, -north, -east * std::tan(lat_rad)};
}

}  // namespace kawara::estimation
