#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/test_doughnut.hpp"
#include "vision/camera/camera_choice.hpp"

/// Every model of the product, in the mounts and crops it is used in: what a pixel sees is seen by
/// that pixel.
namespace kawara::vision {
namespace {

constexpr double kTolerancePx = 0.01;
constexpr double kToleranceRad = 1e-9;

struct Model {
  std::string name;
  std::shared_ptr<const CameraModel> camera;
};

std::vector<Model> AllModels() {
  std::vector<Model> models;
  const auto add_ring = [&](const std::string& name, const DoughnutParameters& p) {
    const auto made = DoughnutCamera::Create(p);
    ASSERT_TRUE(made) << name << ": " << made.error().message;
    models.push_back({name, std::make_shared<const DoughnutCamera>(*made)});
  };
  const DoughnutParameters standard;
  add_ring("doughnut", standard);
  for (const bool mirrored : {false, true}) {
    DoughnutParameters p = standard;
    p.mirrored = mirrored;
    p.forward_deg = mirrored ? -127.0 : 41.0;
    p.v_scale = 1.07;
    p.center_v_px = 480.3;
    p.center_u_px = 530.8;
    add_ring(mirrored ? "doughnut, mirrored" : "doughnut, turned and off the middle", p);
  }
  DoughnutParameters below = standard;
  std::swap(below.phi_top_deg, below.phi_bottom_deg);
  below.l_base_px = below.l_in_px + (below.l_out_px - below.l_in_px) * 50.0 / 80.0;
  add_ring("doughnut, seen from below", below);
  DoughnutParameters disk = standard;
  disk.l_in_px = 0.0;
  disk.phi_top_deg = 90.0;
  disk.phi_bottom_deg = -20.0;
  disk.l_base_px = disk.l_out_px * 90.0 / 110.0;
  add_ring("doughnut without a hole", disk);
  add_ring("doughnut, corrected", CorrectedDoughnut(standard));
  add_ring("doughnut, seen from below, corrected", CorrectedDoughnut(below));
  for (int eighths = 1; eighths <= 7; eighths += 2) {
    add_ring("doughnut at " + std::to_string(eighths) + "/8", standard.Scaled(eighths));
  }
  add_ring("doughnut of 4 Mpx", standard.Resized(2048, 2048));
  add_ring("doughnut in unequal scales", standard.Resized(1400, 900));

  const auto add_sphere = [&](const std::string& name, const PanoramaGeometry& g) {
    const auto made = EquirectangularCamera::Create(g);
    ASSERT_TRUE(made) << name << ": " << made.error().message;
    models.push_back({name, std::make_shared<const EquirectangularCamera>(*made)});
  };
  add_sphere("full sphere", PanoramaGeometry::Full(1024, 512));
  add_sphere("odd sphere", PanoramaGeometry::Full(721, 359));
  add_sphere("band", PanoramaGeometry::Band(1000, {-0.9, 0.5}));
  add_sphere("crop ahead", {300, 200, 2000, 1000, 850, 400});
  add_sphere("crop at the seam", {300, 200, 2000, 1000, 1700, 0});
  return models;
}

TEST(CameraInverse, EveryPixelOfEveryModelComesBackToItself) {
  for (const Model& model : AllModels()) {
    const CameraModel& camera = *model.camera;
    double worst_px = 0.0;
    int seen = 0;
    for (int v = 0; v < camera.height_px(); ++v) {
      for (int u = 0; u < camera.width_px(); ++u) {
        // Not centres only: a place of its own within each pixel.
        const Eigen::Vector2d pixel(u + 0.45 * std::sin(12.9898 * u + 78.233 * v),
                                    v + 0.45 * std::sin(39.346 * u + 11.135 * v));
        const auto ray = camera.Unproject(pixel);
        if (!ray) continue;
        ASSERT_NEAR(ray->norm(), 1.0, 1e-12) << model.name;
        const auto back = camera.Project(*ray);
        ASSERT_TRUE(back) << model.name << " at " << pixel.transpose();
        worst_px = std::max(worst_px, (*back - pixel).norm());
        ++seen;
      }
    }
    EXPECT_LT(worst_px, kTolerancePx) << model.name;
    EXPECT_GT(seen, camera.width_px() * camera.height_px() / 3) << model.name;
  }
}

TEST(CameraInverse, EveryDirectionAModelSeesComesBackToItself) {
  for (const Model& model : AllModels()) {
    const CameraModel& camera = *model.camera;
    int seen = 0;
    for (double phi_deg = -89.7; phi_deg < 90.0; phi_deg += 0.61) {
      for (double theta_deg = -179.9; theta_deg < 180.0; theta_deg += 1.7) {
        const double phi = phi_deg * core::kRadFromDeg;
        const double theta = theta_deg * core::kRadFromDeg;
        const Eigen::Vector3d ray(std::sin(phi), std::cos(phi) * std::sin(theta),
                                  std::cos(phi) * std::cos(theta));
        const auto pixel = camera.Project(2.5 * ray);
        if (!pixel) continue;
        const auto back = camera.Unproject(*pixel);
        ASSERT_TRUE(back) << model.name << " at " << phi_deg << ", " << theta_deg;
        ASSERT_LT((*back - ray).norm(), kToleranceRad)
            << model.name << " at " << phi_deg << ", " << theta_deg;
        ++seen;
      }
    }
    EXPECT_GT(seen, 100) << model.name;
  }
}

TEST(CameraChoice, OnlyTheSizeOfAFullSphereNeedsToBeSaid) {
  EXPECT_EQ((EquirectangularParameters{2000, 600}.Geometry()),
            (PanoramaGeometry{2000, 600, 2000, 1000, 0, 200}));
}

}  // namespace
}  // namespace kawara::vision
