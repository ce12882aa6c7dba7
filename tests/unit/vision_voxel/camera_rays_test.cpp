#include "vision/voxel/camera_rays.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "core/geodesy.hpp"
#include "tests/support/test_doughnut.hpp"
#include "vision/camera/doughnut_camera.hpp"
#include "vision/camera/equirectangular_camera.hpp"

namespace kawara::vision {
namespace {

TEST(CameraRays, DirectionsFindTheirPixelWithinOne) {
  const auto camera = DoughnutCamera::Create(TestDoughnut(400));
  const CameraRays rays(*camera);
  int missed = 0, looked = 0;
  for (int v = 0; v < 400; ++v) {
    for (int u = 0; u < 400; ++u) {
      const auto i = static_cast<std::size_t>(v * 400 + u);
      if (std::isnan(rays.x()[i])) continue;
      ++looked;
      const std::int32_t found = rays.PixelOf(3.0F * rays.ray(i));
      if (found == CameraRays::kNoPixel) {
        ++missed;  // at the rim the nearest direction tried may see nothing
        continue;
      }
      EXPECT_LE(std::abs(found % 400 - u), 1);
      EXPECT_LE(std::abs(found / 400 - v), 1);
    }
  }
  EXPECT_GT(looked, 100000);
  EXPECT_LT(missed, looked / 100);
}

TEST(CameraRays, PixelsPerSteradianAddUpToTheSphere) {
  const auto camera = EquirectangularCamera::Create(PanoramaGeometry::Full(200, 100));
  const CameraRays rays(*camera);
  double sphere_sr = 0.0;
  for (std::int32_t i = 0; i < 200 * 100; ++i)
    sphere_sr += 1.0 / static_cast<double>(rays.PixelsPerSteradian(i));
  EXPECT_NEAR(sphere_sr, 4.0 * core::kPi, 0.005);
}

TEST(CameraRays, SomebodyElsesRaysAreUsedAndNotCopied) {
  const auto camera = DoughnutCamera::Create(TestDoughnut(100));
  const CameraRays own(*camera);
  CameraRays others(*camera, {own.x(), own.y(), own.z()});
  const CameraRays moved = std::move(others);
  EXPECT_EQ(moved.x(), own.x());
  EXPECT_EQ(moved.memory_bytes() + 3 * own.pixels() * sizeof(float), own.memory_bytes());
  for (std::size_t i = 0; i < own.pixels(); ++i) {
    if (std::isnan(own.x()[i])) continue;
    ASSERT_EQ(moved.PixelOf(own.ray(i)), own.PixelOf(own.ray(i)));
  }
}

TEST(CameraRays, NothingIsSeenOutsideTheField) {
  const auto camera = DoughnutCamera::Create(TestDoughnut(400));
  const CameraRays rays(*camera);
  EXPECT_EQ(rays.PixelOf({1.0F, 0.0F, 0.0F}), CameraRays::kNoPixel);   // straight up
  EXPECT_EQ(rays.PixelOf({-1.0F, 0.0F, 0.0F}), CameraRays::kNoPixel);  // the robot itself
  EXPECT_TRUE(std::isnan(rays.x()[0]));
}

}  // namespace
}  // namespace kawara::vision
