#include "vision/camera/half_scale_camera.hpp"

#include <gtest/gtest.h>

#include "tests/support/test_doughnut.hpp"
#include "vision/camera/equirectangular_camera.hpp"

namespace kawara::vision {
namespace {

// The middle of pixels 2i and 2i + 1, as JPEG places chroma samples.
TEST(HalfScaleCamera, APixelLooksBetweenItsFour) {
  const DoughnutCamera full = *DoughnutCamera::Create(TestDoughnut(400));
  const HalfScaleCamera half(full);
  EXPECT_EQ(half.width_px(), 200);
  for (const auto& [u, v] : {std::pair{100, 40}, {31, 77}, {150, 120}}) {
    const auto ray = half.Unproject({u, v});
    ASSERT_TRUE(ray);
    EXPECT_LT((*ray - *full.Unproject({2 * u + 0.5, 2 * v + 0.5})).norm(), 1e-12);
    EXPECT_LT((*half.Project(*ray) - Eigen::Vector2d(u, v)).norm(), 1e-9);
  }
}

TEST(HalfScaleCamera, TheLastPixelOfAnOddSizeIsTheLastOfTheFull) {
  const EquirectangularCamera full = *EquirectangularCamera::Create({400, 67, 400, 200, 0, 61});
  const HalfScaleCamera half(full);
  EXPECT_EQ(half.height_px(), 34);
  EXPECT_LT((*half.Unproject({9, 33}) - *full.Unproject({18.5, 66})).norm(), 1e-12);
  EXPECT_LT((*half.Unproject({9, 33.5}) - *full.Unproject({18.5, 66.5})).norm(), 1e-12);
  EXPECT_LT((*half.Unproject({9, 32}) - *full.Unproject({18.5, 64.5})).norm(), 1e-12);
}

}  // namespace
}  // namespace kawara::vision
