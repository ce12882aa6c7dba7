#include "sim/vehicle/normal_gravity.hpp"

#include <cmath>

namespace kawara::sim {
namespace {

constexpr double kSemiMajor_m = 6378137.0;
constexpr double kFlattening = 1.0 / 298.257223563;
constexpr double kEccentricitySquared = kFlattening * (2.0 - kFlattening);
constexpr double kEquatorGravity_mps2 = 9.7803253359;
constexpr double kSomigliana = 0.00193185265241;  ///< b gamma_pole / (a gamma_equator) - 1
constexpr double kGeodynamic = 0.00344978650684;  ///< omega^2 a^2 b / GM

}  // namespace

Eigen::Vector3d NormalGravityNed(const core::Geodetic& place) {
  const double sin2 = std::pow(std::sin(place.lat_rad), 2);
  const double on_ellipsoid = kEquatorGravity_mps2 * (1.0 + kSomigliana * sin2) /
                              std::sqrt(1.0 - kEccentricitySquared * sin2);
  const double h = place.h_ellipsoidal_m / kSemiMajor_m;
  const double down =
      on_ellipsoid *
      (1.0 - 2.0 * (1.0 + kFlattening + kGeodynamic - 2.0 * kFlattening * sin2) * h + 3.0 * h * h);
  const double north = -8.08e-9 * place.h_ellipsoidal_m * std::sin(2.0 * place.lat_rad);
  return {north, 0.0, down};
}

}  // namespace kawara::sim
