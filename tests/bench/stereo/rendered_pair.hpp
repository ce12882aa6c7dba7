#pragma once
#include <algorithm>
#include <memory>
#include <random>
#include <thread>

#include "core/geodesy.hpp"
#include "tests/support/stereo_lab.hpp"
#include "vision/camera/doughnut_camera.hpp"
#include "vision/stereo/stereo_view.hpp"

namespace kawara::vision::stereo_bench {

using test_support::StereoLab;
constexpr double kBaseline = 0.5;  ///< [m]

/// Two pictures of the made street, with their true poses.
struct Pair {
  std::shared_ptr<const CameraModel> model;
  std::shared_ptr<const StereoCamera> camera;
  StereoLab::Frame a, b;
  Eigen::Isometry3d pose_a, pose_b;
  StereoView view_a() const { return {camera.get(), a.view(), pose_a}; }
  StereoView view_b() const { return {camera.get(), b.view(), pose_b}; }
};

inline Eigen::Isometry3d Pose(double along_m, std::mt19937& dice) {
  const auto sway = [&](double range) {
    return range * (2.0 * (static_cast<double>(dice()) / 4294967295.0) - 1.0);
  };
  Eigen::Matrix3d map_from_frd;
  map_from_frd << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  const double degree = core::kRadFromDeg;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(along_m, sway(0.03), 2.0 + sway(0.01));
  pose.linear() =
      map_from_frd *
      core::RotationNedFromBody({sway(0.5 * degree), sway(0.5 * degree), sway(3.0 * degree)}) *
      BodyFromCamera();
  return pose;
}

inline Pair RenderPair(std::uint32_t seed, int size_px, double vehicle_contrast, double exposure) {
  Pair pair;
  pair.model = std::make_shared<DoughnutCamera>(
      *DoughnutCamera::Create(DoughnutParameters{}.Resized(size_px, size_px)));
  pair.camera = std::make_shared<StereoCamera>(pair.model);
  test_support::StereoLabOptions options;
  options.seed = seed;
  options.vehicle_contrast = vehicle_contrast;
  const StereoLab lab(options);
  std::mt19937 dice(seed);
  pair.pose_a = Pose(-kBaseline / 2, dice);
  pair.pose_b = Pose(kBaseline / 2, dice);
  std::thread other([&] { pair.b = lab.Render(*pair.model, pair.pose_b, 2 * seed + 1); });
  pair.a = lab.Render(*pair.model, pair.pose_a, 2 * seed);
  other.join();
  for (auto& level : pair.b.rgb) {
    level = static_cast<std::uint8_t>(std::min(255.0, exposure * level + 0.5));
  }
  return pair;
}

}  // namespace kawara::vision::stereo_bench
