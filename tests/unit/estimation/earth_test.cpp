#include "estimation/earth.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geodesy.hpp"
#include "estimation/error_state.hpp"

namespace kawara::estimation {
namespace {

/// Source: NIMA TR8350.2, table 3.4 (derived geometric and physical constants) for equator and
/// pole.
TEST(Earth, NormalGravityOfEquatorAndPole) {
  EXPECT_NEAR(NormalGravity(0.0, 0.0), 9.7803253359, 1e-10);
  EXPECT_NEAR(NormalGravity(core::kPi / 2.0, 0.0), 9.8321849379, 2e-10);
}

/// A satellite's distance is far outside the series; a mountain's is inside: the inverse square of
/// the distance within 0.2 % of the change.
TEST(Earth, GravityFallsWithHeight) {
  const double ground = NormalGravity(0.8, 0.0);
  const double peak = NormalGravity(0.8, 4000.0);
  EXPECT_NEAR((ground - peak) / 4000.0, 3.086e-6, 0.01e-6);  // the free-air gradient
}

/// a (1 - e^2) and a at the equator, a^2 / b both at the pole.
TEST(Earth, RadiiOfEquatorAndPole) {
  const auto equator = RadiiAt(0.0);
  EXPECT_NEAR(equator.meridian_m, 6335439.3273, 1e-3);
  EXPECT_NEAR(equator.prime_vertical_m, 6378137.0, 1e-6);
  const auto pole = RadiiAt(core::kPi / 2.0);
  EXPECT_NEAR(pole.meridian_m, 6399593.6258, 1e-3);
  EXPECT_NEAR(pole.prime_vertical_m, 6399593.6258, 1e-3);
}

TEST(Earth, TurnsOnceInASiderealDay) {
  for (const double lat : {-1.2, 0.0, 0.62, 1.5}) {
    const Eigen::Vector3d rate = EarthRateNed(lat);
    EXPECT_NEAR(2.0 * core::kPi / rate.norm(), 86164.1, 0.1);
    // Its axis stands over the northern horizon by the latitude.
    EXPECT_NEAR(std::atan2(-rate.z(), rate.x()), lat, 1e-12);
  }
}

/// The frame a second later, by geometry, against the rate.
TEST(Earth, TransportRateIsTheTurnOfTheFrame) {
  const core::Geodetic here{0.62, 2.4, 300.0};
  const Eigen::Vector3d velocity(30.0, -20.0, 5.0);
  const auto frame = [](const core::Geodetic& g) {
    Eigen::Matrix3d ecef_from_ned;
    const double sl = std::sin(g.lat_rad), cl = std::cos(g.lat_rad);
    const double so = std::sin(g.lon_rad), co = std::cos(g.lon_rad);
    ecef_from_ned << -sl * co, -so, -cl * co, -sl * so, co, -cl * so, cl, 0.0, -sl;
    return ecef_from_ned;
  };
  const Eigen::Matrix3d before = frame(Displaced(here, -0.5 * velocity));
  const Eigen::Matrix3d after = frame(Displaced(here, 0.5 * velocity));
  const Eigen::Matrix3d turn = before.transpose() * after;
  const Eigen::Vector3d measured(turn(2, 1) - turn(1, 2), turn(0, 2) - turn(2, 0),
                                 turn(1, 0) - turn(0, 1));
  EXPECT_LT((0.5 * measured - TransportRateNed(0.62, 300.0, velocity)).norm(), 1e-10);
}

TEST(Earth, DisplacedByMetresAgreesWithTheTangentPlane) {
  const core::Geodetic here{0.62, 2.4, 300.0};
  const Eigen::Vector3d step(3.0, -2.0, 1.5);
  EXPECT_LT((core::NedBetween(here, Displaced(here, step)) - step).norm(), 2e-5);
  EXPECT_LT((Displacement(here, Displaced(here, step)) - step).norm(), 1e-8);
}

TEST(Earth, DisplacedGoesOnBeyondTheDateLine) {
  const core::Geodetic here{0.3, core::kPi - 1e-8, 0.0};
  const core::Geodetic there = Displaced(here, {0.0, 1.0, 0.0});
  EXPECT_LT(there.lon_rad, -3.0);
  EXPECT_NEAR(Displacement(here, there).y(), 1.0, 1e-8);
}

}  // namespace
}  // namespace kawara::estimation
