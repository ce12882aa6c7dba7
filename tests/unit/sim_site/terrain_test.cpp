#include "sim/site/terrain.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "committed_sites.hpp"
#include "sim/dice.hpp"
#include "sim/site/scene_builder.hpp"

namespace kawara::sim {
namespace {

SiteConfig Bent() {
  SiteConfig site = EmptySite();
  site.terrain.slope_east_percent = 3.0;
  site.terrain.undulation_m = 0.3;
  site.road.points_m = {{-35, -20}, {0, -20}, {20, 28}};
  site.road.corner_radius_m = 12.0;
  return site;
}

TEST(Terrain, EveryPlaceInsideHasExactlyOneTriangle) {
  const SiteConfig site = Bent();
  const Terrain terrain(site);
  double area_m2 = 0.0;
  Eigen::AlignedBox2d land;
  for (const Terrain::Triangle& t : terrain.triangles()) {
    const Eigen::Vector3d a = t.corners_m[0].cast<double>();
    const Eigen::Vector3d b = t.corners_m[1].cast<double>(), c = t.corners_m[2].cast<double>();
    if (t.part == GroundPart::kLand) land.extend(a.head<2>()).extend(b.head<2>());
    // Inside the detailed part only: the road runs on past the land's rim.
    if (std::max({std::abs(a.x()), std::abs(b.x()), std::abs(c.x())}) > 40.01 ||
        std::max({std::abs(a.y()), std::abs(b.y()), std::abs(c.y())}) > 30.01)
      continue;
    area_m2 += (b - a).head<2>().x() * (c - a).y() / 2 - (b - a).y() * (c - a).x() / 2;
  }
  // Strips of the road that straddle the rim are left out of the sum.
  EXPECT_LT(area_m2, 80.0 * 60.0 + 0.5);
  EXPECT_GT(area_m2, 80.0 * 60.0 - 60.0);
}

TEST(Terrain, GroundHeightIsTheMeshesHeight) {
  // Against the scene's ground and kerbs, by brute force over their triangles.
  const SiteConfig site = Bent();
  const Terrain terrain(site);
  const Scene scene = BuildScene(site, terrain, SiteState::kAfter);
  Dice dice(7);
  int hits = 0;
  for (int n = 0; n < 100; ++n) {
    const double e = -40 + 80 * dice.Uniform(), north = -30 + 60 * dice.Uniform();
    for (const Mesh& mesh : scene.meshes) {
      for (const auto& t : mesh.triangles) {
        const Eigen::Vector3d a = mesh.vertices_m[t[0]].cast<double>();
        const Eigen::Vector3d ab = mesh.vertices_m[t[1]].cast<double>() - a;
        const Eigen::Vector3d ac = mesh.vertices_m[t[2]].cast<double>() - a;
        const double area = ab.x() * ac.y() - ab.y() * ac.x();
        const double px = e - a.x(), py = north - a.y();
        const double u = (px * ac.y() - py * ac.x()) / area;
        const double v = (ab.x() * py - ab.y() * px) / area;
        if (u < 0.001 || v < 0.001 || u + v > 0.999) continue;
        ++hits;
        EXPECT_NEAR(terrain.GroundHeight(e, north), a.z() + u * ab.z() + v * ac.z(), 1e-4)
            << e << " " << north;
      }
    }
  }
  EXPECT_GT(hits, 92);  // the rest fell on edges
}

TEST(Terrain, TrianglesFaceUp) {
  const Terrain terrain(Bent());
  for (const Terrain::Triangle& t : terrain.triangles()) {
    const Eigen::Vector3f normal =
        (t.corners_m[1] - t.corners_m[0]).cross(t.corners_m[2] - t.corners_m[0]);
    ASSERT_GT(normal.z(), 0.0F);
  }
}

TEST(Terrain, GroundHasNoStepsButTheKerbs) {
  const SiteConfig site = Bent();
  const Terrain terrain(site);
  constexpr double kStep_m = 0.01;
  for (double north = -29.5; north < 29.5; north += 9.7) {
    for (double e = -39.5; e < 39.5; e += kStep_m) {
      const double rise =
          std::abs(terrain.GroundHeight(e + kStep_m, north) - terrain.GroundHeight(e, north));
      const GroundPart part = terrain.PartAt(e, north), next = terrain.PartAt(e + kStep_m, north);
      const auto kerb = [](GroundPart p) {
        return p == GroundPart::kKerbLeft || p == GroundPart::kKerbRight;
      };
      ASSERT_LT(rise, kerb(part) || kerb(next) ? 0.06 : 0.004) << e << " " << north;
    }
  }
}

TEST(Terrain, RoadHasCrownAndKerbsAsConfigured) {
  SiteConfig site = EmptySite();
  site.terrain.undulation_m = 0.0;
  site.road.roughness_m = 0.0;
  site.road.centre_line = false;  // its strip lies level
  const Terrain terrain(site);
  const double half = site.road.width_m / 2.0;
  const double gutter = terrain.GroundHeight(0.0, half - 1e-4);
  EXPECT_NEAR(terrain.GroundHeight(0, 0) - gutter, half * site.road.crown_percent / 100.0, 1e-3);
  EXPECT_NEAR(terrain.GroundHeight(0, half + 0.1) - gutter, site.road.kerb_height_m, 1e-4);
  EXPECT_NEAR(terrain.GroundHeight(0, -half - 0.1) - gutter, site.road.kerb_height_m, 1e-4);
  EXPECT_EQ(terrain.PartAt(0.0, half + 0.1), GroundPart::kKerbLeft);
  EXPECT_EQ(terrain.PartAt(0.0, -half - 0.1), GroundPart::kKerbRight);
  EXPECT_EQ(terrain.PartAt(0.0, half + 1.0), GroundPart::kPavement);
  EXPECT_EQ(terrain.PartAt(0.0, 1.0), GroundPart::kRoad);
  EXPECT_EQ(terrain.PartAt(0.0, 20.0), GroundPart::kLand);
}

TEST(Terrain, SlopeIsThatOfTheFile) {
  SiteConfig site = EmptySite();
  site.terrain.undulation_m = 0.0;
  site.terrain.slope_east_percent = 4.0;
  site.terrain.slope_north_percent = -2.0;
  const Terrain terrain(site);
  EXPECT_NEAR(terrain.GroundHeight(20, 20) - terrain.GroundHeight(-20, 20), 1.6, 1e-4);
  EXPECT_NEAR(terrain.GroundHeight(20, 25) - terrain.GroundHeight(20, 15), -0.2, 1e-4);
}

TEST(Terrain, OutsideTheLandItIsTheNearestHeight) {
  const Terrain terrain(EmptySite());
  EXPECT_TRUE(std::isfinite(terrain.GroundHeight(1e6, -1e6)));
}

}  // namespace
}  // namespace kawara::sim
