#include "vision/camera/equirectangular_camera.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace kawara::vision {
namespace {

constexpr double kDeg = core::kRadFromDeg;

TEST(EquirectangularCamera, CentreIsForwardAndRightIsRight) {
  const auto camera = EquirectangularCamera::Create(PanoramaGeometry::Full(3600, 1800));
  ASSERT_TRUE(camera);
  struct Case {
    Eigen::Vector3d ray;  // up, right, forward
    Eigen::Vector2d pixel;
  };
  const Case cases[] = {
      {{0, 0, 1}, {1799.5, 899.5}}, {{0, 1, 0}, {2699.5, 899.5}},   {{0, -1, 0}, {899.5, 899.5}},
      {{1, 0, 1}, {1799.5, 449.5}}, {{-1, 0, 1}, {1799.5, 1349.5}}, {{0, -1e-9, -1}, {-0.5, 899.5}},
  };
  for (const Case& c : cases) {
    const auto pixel = camera->Project(c.ray);
    ASSERT_TRUE(pixel);
    EXPECT_LT((*pixel - c.pixel).norm(), 1e-5) << c.pixel.transpose();
  }
}

TEST(EquirectangularCamera, UnprojectInvertsProjectInACroppedPicture) {
  const PanoramaGeometry geometry{500, 300, 2000, 1000, 700, 250};
  const auto camera = EquirectangularCamera::Create(geometry);
  ASSERT_TRUE(camera);
  for (double v = -0.4; v < 299.5; v += 23.3) {
    for (double u = -0.4; u < 499.5; u += 31.7) {
      const auto ray = camera->Unproject({u, v});
      ASSERT_TRUE(ray);
      const auto pixel = camera->Project(*ray);
      ASSERT_TRUE(pixel);
      EXPECT_LT((*pixel - Eigen::Vector2d(u, v)).norm(), 1e-9);
    }
  }
  EXPECT_FALSE(camera->Unproject({500.0, 10.0}));
  EXPECT_FALSE(camera->Project({0, 0, -1}));  // behind: not in the crop
}

TEST(EquirectangularCamera, ElevationsAreThoseOfTheEdgeRows) {
  const auto camera =
      EquirectangularCamera::Create(PanoramaGeometry::Band(3600, {-50 * kDeg, 30 * kDeg}));
  ASSERT_TRUE(camera);
  EXPECT_EQ(camera->geometry(), (PanoramaGeometry{3600, 800, 3600, 1800, 0, 600}));
  EXPECT_NEAR(camera->Elevations().top_rad, 30 * kDeg, 1e-12);
  EXPECT_NEAR(camera->Elevations().bottom_rad, -50 * kDeg, 1e-12);
}

TEST(EquirectangularCamera, ResizedKeepsTheSameCrop) {
  const PanoramaGeometry big = PanoramaGeometry::Band(3600, {-50 * kDeg, 30 * kDeg});
  EXPECT_EQ(big.Resized(900), (PanoramaGeometry{900, 200, 900, 450, 0, 150}));
}

TEST(EquirectangularCamera, RefusesACropOutsideTheSphere) {
  for (const PanoramaGeometry& g :
       {PanoramaGeometry{}, PanoramaGeometry{100, 50, 99, 50, 0, 0},
        PanoramaGeometry{100, 50, 100, 50, 1, 0}, PanoramaGeometry{100, 50, 100, 50, 0, -1},
        PanoramaGeometry{100, 50, -2147483647 - 1, 50, 0, 0}}) {
    EXPECT_FALSE(EquirectangularCamera::Create(g));
  }
}

}  // namespace
}  // namespace kawara::vision
