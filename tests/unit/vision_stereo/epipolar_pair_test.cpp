#include "vision/stereo/epipolar_pair.hpp"

#include <gtest/gtest.h>

#include <random>

namespace kawara::vision {
namespace {

Eigen::Isometry3d Pose(std::mt19937& dice) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto three = [&] { return Eigen::Vector3d(uniform(dice), uniform(dice), uniform(dice)); };
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(3.0 * uniform(dice), three().normalized()).toRotationMatrix();
  pose.translation() = three();
  return pose;
}

TEST(EpipolarPair, BothViewsSeeAPointOnOneMeridianAndItsRangeComesBack) {
  std::mt19937 dice(1);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Isometry3d a = Pose(dice), b = Pose(dice);
    const Eigen::Vector3d point = 5.0 * Pose(dice).translation();
    const auto pair = EpipolarPair::FromPoses(a, b);
    ASSERT_TRUE(pair);
    const Eigen::Vector3d from_a =
        pair->a_from_epipolar.transpose() * (a.inverse() * point).normalized();
    const Eigen::Vector3d from_b =
        pair->b_from_epipolar.transpose() * (b.inverse() * point).normalized();
    EXPECT_NEAR(std::atan2(from_a.z(), from_a.y()), std::atan2(from_b.z(), from_b.y()), 1e-9);
    const double alpha_a = std::acos(from_a.x()), alpha_b = std::acos(from_b.x());
    const double range = (point - a.translation()).norm();
    EXPECT_NEAR(pair->Range(alpha_a, alpha_b - alpha_a), range, 1e-6 * range);
    EXPECT_NEAR(pair->Disparity(alpha_a, range), alpha_b - alpha_a, 1e-9);
  }
}

TEST(EpipolarPair, RayIsWhatItsAnglesSay) {
  const Eigen::Vector3d ray = EpipolarPair::Ray(0.7, 2.1);
  EXPECT_NEAR(ray.norm(), 1.0, 1e-15);
  EXPECT_NEAR(std::acos(ray.x()), 0.7, 1e-12);
  EXPECT_NEAR(std::atan2(ray.z(), ray.y()), 2.1, 1e-12);
}

TEST(EpipolarPair, TheSeamIsAbove) {
  Eigen::Isometry3d a = Eigen::Isometry3d::Identity(), b = a;
  b.translation() = Eigen::Vector3d(0.05, 0.0, 0.5);  // ahead and a little up, camera frame: X up
  const auto pair = EpipolarPair::FromPoses(a, b);
  ASSERT_TRUE(pair);
  EXPECT_GT((pair->a_from_epipolar * EpipolarPair::Ray(core::kPi / 2, 0.0)).x(), 0.9);
}

TEST(EpipolarPair, StraightUpHasAFrameToo) {
  Eigen::Isometry3d a = Eigen::Isometry3d::Identity(), b = a;
  b.translation() = Eigen::Vector3d(0.5, 0.0, 0.0);
  const auto pair = EpipolarPair::FromPoses(a, b);
  ASSERT_TRUE(pair);
  EXPECT_NEAR(pair->a_from_epipolar.determinant(), 1.0, 1e-12);
}

TEST(EpipolarPair, NoBaselineIsRefused) {
  const Eigen::Isometry3d a = Eigen::Isometry3d::Identity();
  const auto pair = EpipolarPair::FromPoses(a, a);
  ASSERT_FALSE(pair);
  EXPECT_EQ(pair.error().code, core::ErrorCode::kInvalidArgument);
  EXPECT_NE(pair.error().message.find("same place"), std::string::npos);
}

TEST(EpipolarPair, NoDisparityIsInfinitelyFar) {
  EpipolarPair pair;
  pair.baseline_m = 0.5;
  EXPECT_TRUE(std::isinf(pair.Range(1.0, 0.0)));
}

}  // namespace
}  // namespace kawara::vision
