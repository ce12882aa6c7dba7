#include "core/geodesy.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "tests/support/counting_allocator.hpp"

namespace kawara::core {
namespace {

constexpr double kA = 6378137.0;
constexpr double kB = 6356752.314245179;  // WGS 84 semi-minor axis
constexpr double kNanometres = 5e-9;      // of positions on the scale of the earth in doubles

Geodetic Deg(double lat, double lon, double h) { return {lat * kRadFromDeg, lon * kRadFromDeg, h}; }

struct KnownEcef {
  Geodetic g;
  Eigen::Vector3d ecef_m;
};
class KnownPlaces : public ::testing::TestWithParam<KnownEcef> {};
TEST_P(KnownPlaces, ForwardAndBack) {
  const auto& [g, ecef] = GetParam();
  EXPECT_LT((EcefFromGeodetic(g) - ecef).norm(), 1e-4);
  const Geodetic back = GeodeticFromEcef(EcefFromGeodetic(g));
  EXPECT_NEAR(back.lat_rad, g.lat_rad, 1e-15 + 2e-16);
  EXPECT_NEAR(WrapPi(back.lon_rad - g.lon_rad), 0.0, 1e-15);
  EXPECT_NEAR(back.h_ellipsoidal_m, g.h_ellipsoidal_m, kNanometres);
}
// The semi-axes of the ellipsoid, and one place in between (from the closed formula, by hand).
// transmitted.
INSTANTIATE_TEST_SUITE_P(
    Table, KnownPlaces,
    ::testing::Values(
        KnownEcef{Deg(0, 0, 0), {kA, 0, 0}}, KnownEcef{Deg(0, 90, 100), {0, kA + 100, 0}},
        KnownEcef{Deg(0, 180, 0), {-kA, 0, 0}}, KnownEcef{Deg(90, 0, 10), {0, 0, kB + 10}},
        KnownEcef{Deg(-90, 0, -10), {0, 0, -kB + 10}},
        KnownEcef{Deg(45, 45, 0), {3194419.1450605732, 3194419.1450605732, 4487348.4088658970}}));

TEST(LocalEnu, AxesPointEastNorthUp) {
  const LocalEnu plane(Deg(38.2595, 140.838, 62));
  EXPECT_LT(plane.FromGeodetic(plane.origin()).norm(), kNanometres);
  EXPECT_GT(plane.FromGeodetic(Deg(38.2595, 140.839, 62)).x(), 80.0);
  EXPECT_GT(plane.FromGeodetic(Deg(38.2605, 140.838, 62)).y(), 110.0);
  EXPECT_LT((plane.FromGeodetic(Deg(38.2595, 140.838, 65)) - Eigen::Vector3d(0, 0, 3)).norm(),
            kNanometres);
}

TEST(LocalEnu, IsTheTangentPlane) {
  // 1 km away on the equator: the ellipsoid has dropped by d^2 / 2a.
  const LocalEnu plane(Deg(0, 0, 0));
  const Eigen::Vector3d p = plane.FromGeodetic({0, 1000.0 / kA, 0});
  EXPECT_NEAR(p.x(), kA * std::sin(1000.0 / kA), 1e-8);
  EXPECT_NEAR(p.z(), kA * (std::cos(1000.0 / kA) - 1.0), 1e-8);
}

TEST(LocalEnu, RoundTripsOverPolesAndAntimeridian) {
  for (const Geodetic& origin : {Deg(38, 140, 60), Deg(0, 180, 0), Deg(10, -179.9999, 0),
                                 Deg(90, 0, 0), Deg(-89.9999, 30, 5)}) {
    const LocalEnu plane(origin);
    for (const Eigen::Vector3d& enu :
         {Eigen::Vector3d(100, -50, 3), Eigen::Vector3d(-2000, 3000, -20)}) {
      EXPECT_LT((plane.FromGeodetic(plane.ToGeodetic(enu)) - enu).norm(), 2.0 * kNanometres);
    }
  }
}

/// OffsetNed against GeographicLib's tangent plane, everywhere and from millimetres to kilometres.
TEST(OffsetNed, AgreesWithTheTangentPlane) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int i = 0; i < 2000; ++i) {
    Geodetic g = Deg(90.0 * unit(random), 180.0 * unit(random), 4000.0 * unit(random));
    if (i % 10 == 0) g.lat_rad = std::copysign(kPi / 2.0 - 1e-6, g.lat_rad);
    if (i % 10 == 1) g.lon_rad = kPi;
    const double scale = std::pow(10.0, 3.0 * unit(random));
    const Eigen::Vector3d ned(scale * unit(random), scale * unit(random), scale * unit(random));
    const LocalEnu plane(g);
    const Eigen::Vector3d enu = plane.FromGeodetic(OffsetNed(g, ned));
    EXPECT_LT((enu - Eigen::Vector3d(ned.y(), ned.x(), -ned.z())).norm(), 2.0 * kNanometres) << i;
    EXPECT_LT((NedBetween(g, OffsetNed(g, ned)) - ned).norm(), 2.0 * kNanometres) << i;
  }
}

TEST(OffsetNed, ZeroChangesNothing) {
  const Geodetic g = Deg(38.2595, 140.838, 62);
  const Geodetic same = OffsetNed(g, Eigen::Vector3d::Zero());
  EXPECT_EQ(same.lat_rad, g.lat_rad);
  EXPECT_EQ(same.lon_rad, g.lon_rad);
  EXPECT_EQ(same.h_ellipsoidal_m, g.h_ellipsoidal_m);
}

TEST(OffsetNed, CrossesTheAntimeridian) {
  const Geodetic east = OffsetNed(Deg(10, 179.99999, 0), {0, 5, 0});
  EXPECT_LT(east.lon_rad, -3.1415);
  const Geodetic west = OffsetNed(Deg(10, -179.99999, 0), {0, -5, 0});
  EXPECT_GT(west.lon_rad, 3.1415);
}

TEST(OffsetNed, NeverAllocates) {
  OffsetNed(Deg(1, 2, 3), {1, 2, 3});  // GeographicLib's ellipsoid comes to life at its first use
  const std::uint64_t allocations = kawara::testing::AllocationsOfThisThread();
  OffsetNed(Deg(38, 140, 60), {1, 2, 3});
  NedBetween(Deg(38, 140, 60), Deg(38.0001, 140, 60));
  EXPECT_EQ(kawara::testing::AllocationsOfThisThread(), allocations);
}

TEST(Attitude, ConventionIsNedToFrd) {
  // Heading east: forward points east. Nose up: forward points up (negative down). Right wing down:
  // right points down.
  EXPECT_LT(
      (RotationNedFromBody({0, 0, kPi / 2}) * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY())
          .norm(),
      1e-15);
  EXPECT_LT(
      (RotationNedFromBody({0, kPi / 2, 0}) * Eigen::Vector3d::UnitX() + Eigen::Vector3d::UnitZ())
          .norm(),
      1e-15);
  EXPECT_LT(
      (RotationNedFromBody({kPi / 2, 0, 0}) * Eigen::Vector3d::UnitY() - Eigen::Vector3d::UnitZ())
          .norm(),
      1e-15);
}

TEST(Attitude, RoundTrips) {
  for (double roll = -3.1; roll < 3.15; roll += 0.3) {
    for (double pitch = -1.5; pitch < 1.51; pitch += 0.25) {
      for (double yaw = -3.1; yaw < 3.15; yaw += 0.3) {
        const Attitude a = AttitudeFromRotation(RotationNedFromBody({roll, pitch, yaw}));
        EXPECT_NEAR(a.roll_rad, roll, 1e-13);
        EXPECT_NEAR(a.pitch_rad, pitch, 1e-13);
        EXPECT_NEAR(a.yaw_rad, yaw, 1e-13);
      }
    }
  }
}

TEST(Attitude, StraightUpAndDownKeepTheRotation) {
  for (const double pitch : {kPi / 2, -kPi / 2, kPi / 2 - 1e-10, -kPi / 2 + 1e-7}) {
    for (const double roll : {0.0, 0.7, -2.0}) {
      const Eigen::Matrix3d R = RotationNedFromBody({roll, pitch, 1.1});
      const Attitude a = AttitudeFromRotation(R);
      EXPECT_NEAR(a.pitch_rad, pitch, 1e-9);
      EXPECT_LT((RotationNedFromBody(a) - R).norm(), 1e-8) << pitch << " " << roll;
    }
  }
}

TEST(WrapPi, IntoTheHalfOpenInterval) {
  EXPECT_EQ(WrapPi(kPi), kPi);
  EXPECT_EQ(WrapPi(-kPi), kPi);
  EXPECT_NEAR(WrapPi(3 * kPi + 0.1), -kPi + 0.1, 1e-12);
  EXPECT_NEAR(WrapPi(-1000.0), std::remainder(-1000.0, 2 * kPi), 1e-12);
  EXPECT_EQ(WrapPi(0.25), 0.25);
}

}  // namespace
}  // namespace kawara::core
