#pragma once
#include <Eigen/Core>

#include "core/geodesy.hpp"

namespace kawara::sim {

/// Rate at which the Earth turns [rad/s], WGS 84.
constexpr double kEarthRate_radps = 7.292115e-5;

/// What a plumb line feels (attraction and centrifugal force together) at a place, north, east,
/// down [m/s^2]: Somigliana's formula on the WGS 84 ellipsoid, to the second order of height, and
/// the small northern part that the plumb line's curvature gives. No anomalies: a real place
/// differs by some 1e-4 m/s^2. Source: NIMA TR8350.2 (third edition), eq. 4-1 and 4-3; P. Groves,
/// Principles of GNSS, Inertial and Multisensor Integrated Navigation Systems (2nd ed.), eq. 2.140.
Eigen::Vector3d NormalGravityNed(const core::Geodetic& place);

}  // namespace kawara::sim
