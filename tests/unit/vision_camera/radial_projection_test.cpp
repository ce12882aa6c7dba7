#include "vision/camera/radial_projection.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "tests/support/test_doughnut.hpp"
#include "vision/camera/equirectangular_camera.hpp"

namespace kawara::vision {
namespace {

struct Ring {
  std::string name;
  DoughnutParameters parameters;
};

std::vector<Ring> Rings() {
  std::vector<Ring> rings = {{"standard", TestDoughnut()}, {"4 Mpx", TestDoughnut(2048)}};
  DoughnutParameters turned = TestDoughnut();
  turned.forward_deg = 41.0;
  turned.mirrored = true;
  turned.v_scale = 1.07;
  turned.center_u_px += 13.3;
  rings.push_back({"turned and mirrored", turned});
  DoughnutParameters below = TestDoughnut();
  std::swap(below.phi_top_deg, below.phi_bottom_deg);
  below.l_base_px = below.l_in_px + (below.l_out_px - below.l_in_px) * 50.0 / 80.0;
  rings.push_back({"seen from below", below});
  DoughnutParameters disk = TestDoughnut();
  disk.l_in_px = 0.0;
  disk.phi_top_deg = 90.0;
  disk.phi_bottom_deg = -20.0;
  disk.l_base_px = disk.l_out_px * 90.0 / 110.0;
  rings.push_back({"without a hole", disk});
  rings.push_back({"corrected", CorrectedDoughnut(TestDoughnut())});
  return rings;
}

Eigen::Vector3d RandomRay(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random), z = normal(random);
  return Eigen::Vector3d(x, y, z).normalized();
}

TEST(RadialProjection, PutsRaysWhereTheCameraPutsThem) {
  for (const Ring& ring : Rings()) {
    const auto camera = DoughnutCamera::Create(ring.parameters);
    ASSERT_TRUE(camera) << ring.name;
    const auto fast = RadialProjection::Create(*camera);
    ASSERT_TRUE(fast) << ring.name;
    EXPECT_LE(fast->table_error_px(), RadialProjection::kTableTolerancePx) << ring.name;
    std::mt19937 random(5);
    double worst_px = 0.0;
    int seen = 0;
    for (int i = 0; i < 100000; ++i) {
      const Eigen::Vector3d ray = RandomRay(random);
      const Eigen::Vector3f optical = (fast->R_optical_camera() * ray).cast<float>();
      float u = 0, v = 0;
      if (!fast->Project(optical.x(), optical.y(), optical.z(), &u, &v)) continue;
      const auto exact = camera->Project(ray);
      if (!exact) continue;  // at the very rim: see the next test
      ++seen;
      worst_px = std::max(worst_px, (Eigen::Vector2f(u, v).cast<double>() - *exact).norm());
    }
    EXPECT_GT(seen, 30000) << ring.name;
    EXPECT_LT(worst_px, 1e-3) << ring.name;
  }
}

TEST(RadialProjection, SeesWhatTheCameraSeesInItsPicture) {
  for (const Ring& ring : Rings()) {
    const auto camera = DoughnutCamera::Create(ring.parameters);
    const auto fast = RadialProjection::Create(*camera);
    ASSERT_TRUE(fast) << ring.name;
    std::mt19937 random(6);
    int different = 0;
    for (int i = 0; i < 100000; ++i) {
      const Eigen::Vector3d ray = RandomRay(random);
      const Eigen::Vector3f optical = (fast->R_optical_camera() * ray).cast<float>();
      float u = 0, v = 0;
      const bool seen = fast->Project(optical.x(), optical.y(), optical.z(), &u, &v);
      const auto exact = camera->Project(ray);
      const bool expected = exact && exact->x() >= -0.5 && exact->y() >= -0.5 &&
                            exact->x() < camera->width_px() - 0.5 &&
                            exact->y() < camera->height_px() - 0.5;
      different += seen != expected ? 1 : 0;
    }
    EXPECT_LE(different, 2) << ring.name << ": only rounding at the rim may differ";
  }
}

TEST(RadialProjection, HasAProperOpticalFrame) {
  for (const OpticalAxis axis : {OpticalAxis::kForward, OpticalAxis::kUp, OpticalAxis::kDown}) {
    const Eigen::Matrix3d R = CameraFromOptical(axis);
    EXPECT_EQ(R * R.transpose(), Eigen::Matrix3d::Identity());
    EXPECT_EQ(R.col(0).cross(R.col(1)), R.col(2)) << "a rotation, not a reflection";
  }
}

TEST(RadialProjection, OfACopyPointsIntoTheCopy) {
  const auto camera = DoughnutCamera::Create(TestDoughnut());
  auto first = RadialProjection::Create(*camera);
  ASSERT_TRUE(first);
  std::optional<RadialProjection> copy = first;
  const std::vector<float> knots(copy->knots().begin(), copy->knots().end());
  first.reset();
  EXPECT_EQ(copy->table().knots, copy->knots().data());
  EXPECT_EQ(std::vector<float>(copy->knots().begin(), copy->knots().end()), knots);
}

TEST(RadialProjection, IsNotForStitchedPictures) {
  const auto sphere = EquirectangularCamera::Create(PanoramaGeometry::Full(512, 256));
  ASSERT_TRUE(sphere);
  EXPECT_FALSE(RadialProjection::Create(*sphere));
}

}  // namespace
}  // namespace kawara::vision
