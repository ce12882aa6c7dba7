#pragma once
#include <Eigen/Geometry>
#include <cmath>
#include <memory>

#include "core/geodesy.hpp"
#include "sim/render/lit_scene.hpp"
#include "vision/camera/doughnut_camera.hpp"
#include "vision/camera/equirectangular_camera.hpp"

namespace kawara::sim {

/// Scenes small enough to know every answer in advance.
inline std::uint32_t AddMaterial(Scene& scene, Pattern pattern = Pattern::kPlain,
                                 std::array<float, 3> rgb = {0.5F, 0.5F, 0.5F}) {
  Material material;
  material.pattern = pattern;
  material.base_rgb = rgb;
  material.seed = static_cast<std::uint32_t>(scene.materials.size()) + 1U;
  scene.materials.push_back(material);
  return static_cast<std::uint32_t>(scene.materials.size() - 1);
}

inline SceneObject& AddObject(Scene& scene, std::uint32_t id) {
  SceneObject object;
  object.id = id;
  scene.objects.push_back(object);
  return scene.objects.back();
}

inline void AddQuad(Mesh& mesh, const std::array<Eigen::Vector3d, 4>& corners) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
  const double u = (corners[1] - corners[0]).norm();
  const double v = (corners[3] - corners[0]).norm();
  const std::array<Eigen::Vector2d, 4> uv{Eigen::Vector2d(0, 0), Eigen::Vector2d(u, 0),
                                          Eigen::Vector2d(u, v), Eigen::Vector2d(0, v)};
  for (std::size_t i = 0; i < 4; ++i) {
    mesh.vertices_m.push_back(corners[i].cast<float>());
    mesh.uv_m.push_back(uv[i].cast<float>());
  }
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
}

inline void AddGround(Scene& scene, double half_m, std::uint32_t object, std::uint32_t material) {
  Mesh mesh;
  mesh.object = object;
  mesh.material = material;
  AddQuad(mesh, {Eigen::Vector3d(-half_m, -half_m, 0), Eigen::Vector3d(half_m, -half_m, 0),
                 Eigen::Vector3d(half_m, half_m, 0), Eigen::Vector3d(-half_m, half_m, 0)});
  scene.meshes.push_back(mesh);
}

inline void AddBox(Scene& scene, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                   std::uint32_t object, std::uint32_t material) {
  Mesh mesh;
  mesh.object = object;
  mesh.material = material;
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool upper : {false, true}) {
      std::array<Eigen::Vector3d, 4> corners;
      for (int i = 0; i < 4; ++i) {
        Eigen::Vector3d c;
        c[axis] = upper ? high[axis] : low[axis];
        c[(axis + 1) % 3] = i == 1 || i == 2 ? high[(axis + 1) % 3] : low[(axis + 1) % 3];
        c[(axis + 2) % 3] = i >= 2 ? high[(axis + 2) % 3] : low[(axis + 2) % 3];
        corners[static_cast<std::size_t>(upper ? i : 3 - i)] = c;
      }
      AddQuad(mesh, corners);
    }
  }
  scene.meshes.push_back(mesh);
}

/// A globe of 4 steps^2 faces, which lie at most radius (pi / steps)^2 / 4 inside the sphere.
inline void AddSphere(Scene& scene, const Eigen::Vector3d& center, double radius_m, int steps,
                      std::uint32_t object, std::uint32_t material) {
  Mesh mesh;
  mesh.object = object;
  mesh.material = material;
  for (int j = 0; j <= steps; ++j) {
    for (int i = 0; i <= 2 * steps; ++i) {
      const double lon = core::kPi * i / steps;
      const double lat = core::kPi * (static_cast<double>(j) / steps - 0.5);
      const Eigen::Vector3d d(std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon),
                              std::sin(lat));
      mesh.vertices_m.push_back((center + radius_m * d).cast<float>());
      mesh.uv_m.emplace_back(static_cast<float>(radius_m * lon),
                             static_cast<float>(radius_m * lat));
    }
  }
  const auto row = static_cast<std::uint32_t>(2 * steps + 1);
  for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(steps); ++j) {
    for (std::uint32_t i = 0; i + 1 < row; ++i) {
      const std::uint32_t a = j * row + i;
      mesh.triangles.push_back({a, a + 1, a + row + 1});
      mesh.triangles.push_back({a, a + row + 1, a + row});
    }
  }
  scene.meshes.push_back(mesh);
}

/// A street's corner: ground, three boxes, a ball.
inline Scene CornerScene() {
  Scene scene;
  AddGround(scene, 40.0, 1, AddMaterial(scene, Pattern::kAsphalt, {0.16F, 0.16F, 0.16F}));
  AddBox(scene, {-8, 6, 0}, {4, 12, 6}, 2,
         AddMaterial(scene, Pattern::kBrick, {0.4F, 0.2F, 0.15F}));
  AddBox(scene, {6, -4, 0}, {9, 9, 4}, 3, AddMaterial(scene, Pattern::kConcrete));
  AddBox(scene, {-7, -5, 0}, {-5, -1, 2}, 4,
         AddMaterial(scene, Pattern::kPlain, {0.1F, 0.3F, 0.6F}));
  AddSphere(scene, {2, 3, 0.5}, 0.5, 24, 5, AddMaterial(scene, Pattern::kTiles));
  for (std::uint32_t id = 1; id <= 5; ++id) AddObject(scene, id);
  return scene;
}

/// Lit coarsely, which is quick.
inline std::shared_ptr<const LitScene> Lit(const Scene& scene) {
  LightSettings light;
  light.cell_m = 1.0;
  light.max_points = 2000;
  light.sky_columns = 128;
  return *LitScene::Create(scene, light);
}

/// The standard ring in another size.
inline std::shared_ptr<const vision::DoughnutCamera> Ring(int side_px) {
  const vision::DoughnutParameters p = vision::DoughnutParameters().Resized(side_px, side_px);
  return std::make_shared<vision::DoughnutCamera>(*vision::DoughnutCamera::Create(p));
}

inline std::shared_ptr<const vision::EquirectangularCamera> Sphere(int width_px) {
  return std::make_shared<vision::EquirectangularCamera>(*vision::EquirectangularCamera::Create(
      vision::PanoramaGeometry::Full(width_px, width_px / 2)));
}

/// The middle of such a picture: `size_px` pixels a side round the forward direction.
inline std::shared_ptr<const vision::EquirectangularCamera> Ahead(int full_width_px, int size_px) {
  const vision::PanoramaGeometry geometry{size_px,
                                          size_px,
                                          full_width_px,
                                          full_width_px / 2,
                                          (full_width_px - size_px) / 2,
                                          (full_width_px / 2 - size_px) / 2};
  return std::make_shared<vision::EquirectangularCamera>(
      *vision::EquirectangularCamera::Create(geometry));
}

}  // namespace kawara::sim
