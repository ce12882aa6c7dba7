#include "sim/render/robot_body.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "core/geodesy.hpp"

namespace kawara::sim {
namespace {

/// Places on the robot are given as forward, right, up from the camera's centre.
Eigen::Vector3f CameraFromRobot(double forward_m, double right_m, double up_m) {
  return Eigen::Vector3d(up_m, right_m, forward_m).cast<float>();
}

class BodyBuilder {
 public:
  std::uint32_t AddMaterial(Pattern pattern, std::array<float, 3> rgb, float scale_m, float gloss) {
    Material material;
    material.pattern = pattern;
    material.base_rgb = rgb;
    material.second_rgb = {rgb[0] * 0.5F, rgb[1] * 0.5F, rgb[2] * 0.5F};
    material.scale_m = scale_m;
    material.gloss = gloss;
    material.seed = static_cast<std::uint32_t>(body.materials.size()) + 1U;
    body.materials.push_back(material);
    return static_cast<std::uint32_t>(body.materials.size() - 1);
  }

  /// Four corners counter-clockwise seen from outside.
  void AddQuad(const std::array<Eigen::Vector3f, 4>& corners, std::uint32_t material) {
    Mesh& mesh = MeshOf(material);
    const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
    const Eigen::Vector3f e = corners[1] - corners[0];
    const Eigen::Vector3f f = corners[3] - corners[0];
    const Eigen::Vector2f size(e.norm(), f.norm());
    const std::array<Eigen::Vector2f, 4> uv{Eigen::Vector2f(0, 0), Eigen::Vector2f(size.x(), 0),
                                            size, Eigen::Vector2f(0, size.y())};
    for (std::size_t i = 0; i < 4; ++i) {
      mesh.vertices_m.push_back(corners[i]);
      mesh.uv_m.push_back(uv[i]);
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
  }

  /// Between two corners in forward, right, up.
  void AddBox(const Eigen::Vector3d& low, const Eigen::Vector3d& high, std::uint32_t material) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const bool upper : {false, true}) {
        const int a = (axis + 1) % 3;
        const int b = (axis + 2) % 3;
        std::array<Eigen::Vector3f, 4> corners;
        for (int i = 0; i < 4; ++i) {
          Eigen::Vector3d c;
          c[axis] = upper ? high[axis] : low[axis];
          c[a] = i == 1 || i == 2 ? high[a] : low[a];
          c[b] = i >= 2 ? high[b] : low[b];
          // Forward, right, up is left-handed, so the lower faces keep this order.
          corners[static_cast<std::size_t>(upper ? 3 - i : i)] =
              CameraFromRobot(c.x(), c.y(), c.z());
        }
        AddQuad(corners, material);
      }
    }
  }

  /// Upright, with a lid.
  void AddCylinder(double forward_m, double right_m, double low_m, double high_m, double radius_m,
                   std::uint32_t material) {
    constexpr int kSides = 16;
    const auto rim = [&](int i, double up_m) {
      const double angle = 2.0 * core::kPi * i / kSides;
      return CameraFromRobot(forward_m + radius_m * std::cos(angle),
                             right_m + radius_m * std::sin(angle), up_m);
    };
    for (int i = 0; i < kSides; ++i) {
      AddQuad({rim(i + 1, low_m), rim(i, low_m), rim(i, high_m), rim(i + 1, high_m)}, material);
      AddQuad({CameraFromRobot(forward_m, right_m, high_m), rim(i + 1, high_m), rim(i, high_m),
               CameraFromRobot(forward_m, right_m, high_m)},
              material);
    }
  }

  RobotBody body;

 private:
  Mesh& MeshOf(std::uint32_t material) {
    for (Mesh& mesh : body.meshes) {
      if (mesh.material == material) return mesh;
    }
    body.meshes.emplace_back();
    body.meshes.back().material = material;
    body.meshes.back().object = kRobotBodyObject;
    return body.meshes.back();
  }
};

}  // namespace

RobotBody SurveyRobotBody(double camera_above_deck_m) {
  const double deck = -camera_above_deck_m;
  BodyBuilder b;
  const auto aluminium = b.AddMaterial(Pattern::kTiles, {0.42F, 0.43F, 0.44F}, 0.18F, 0.04F);
  const auto black = b.AddMaterial(Pattern::kPlain, {0.03F, 0.03F, 0.032F}, 1.0F, 0.03F);
  const auto yellow = b.AddMaterial(Pattern::kPlain, {0.75F, 0.48F, 0.04F}, 1.0F, 0.05F);
  const auto white = b.AddMaterial(Pattern::kPlain, {0.78F, 0.78F, 0.76F}, 1.0F, 0.04F);
  b.AddBox({-0.62, -0.36, deck - 0.18}, {0.58, 0.36, deck}, aluminium);
  for (const double side : {-1.0, 1.0}) {  // tracks
    const double inner = side * 0.37;
    const double outer = side * 0.53;
    b.AddBox({-0.66, std::min(inner, outer), deck - 0.30},
             {0.64, std::max(inner, outer), deck - 0.06}, black);
  }
  b.AddBox({0.40, -0.08, deck}, {0.54, 0.08, deck + 0.07}, yellow);            // laser scanner
  b.AddBox({0.415, -0.075, deck + 0.07}, {0.535, 0.075, deck + 0.12}, black);  // and its window
  b.AddBox({0.40, -0.08, deck + 0.12}, {0.54, 0.08, deck + 0.16}, yellow);
  b.AddBox({-0.50, -0.26, deck}, {-0.16, 0.04, deck + 0.14}, black);  // computer
  b.AddBox({-0.44, 0.12, deck}, {-0.20, 0.30, deck + 0.10}, yellow);  // radio
  b.AddCylinder(0.0, 0.0, deck, -0.12, 0.035, black);                 // camera's mast
  b.AddCylinder(-0.58, -0.28, deck, 0.10, 0.012, aluminium);          // antenna's pole
  b.AddCylinder(-0.58, -0.28, 0.10, 0.15, 0.085, white);
  return std::move(b.body);
}

}  // namespace kawara::sim
