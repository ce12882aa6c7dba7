#pragma once
#include <Eigen/Core>

/// The Earth under a moving frame, WGS 84.
namespace kawara::estimation {

/// Radii of curvature of the meridian and of the prime vertical at a latitude [m].
struct CurvatureRadii {
  double meridian_m;
  double prime_vertical_m;
};
CurvatureRadii RadiiAt(double lat_rad);

/// Normal gravity [m/s^2], down positive. Source: WGS 84 (NIMA TR8350.2), Somigliana's formula
/// (4-1) and its continuation with height (4-3).
double NormalGravity(double lat_rad, double h_ellipsoidal_m);

/// The Earth's own rotation in NED [rad/s].
Eigen::Vector3d EarthRateNed(double lat_rad);

/// Rotation of the NED frame over the ellipsoid by moving on it [rad/s].
Eigen::Vector3d TransportRateNed(double lat_rad, double h_ellipsoidal_m,
                                 const Eigen::Vector3d& velocity_ned_mps);

}  // namespace kawara::estimation
