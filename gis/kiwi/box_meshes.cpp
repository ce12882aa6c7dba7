#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "gis/kiwi/class_colour.hpp"
#include "gis/kiwi/object_exports.hpp"

namespace kawara::gis {
namespace {

std::array<float, 3> Floats(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

/// Node and file names know no dots; the number keeps names apart.
std::string MeshName(const core::ChangedObject& object, std::size_t number) {
  std::string name = "object" + std::to_string(number) + "_" + object.uid;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
}

void AddSide(core::TexturedMesh& mesh, const core::UprightBox& box, std::size_t side) {
  auto corners = box.CornersOf(static_cast<core::BoxSide>(side));
  for (Eigen::Vector3d& corner : corners) corner -= box.centre_m;
  const Eigen::Vector3d normal =
      (corners[3] - corners[0]).cross(corners[1] - corners[0]).normalized();
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  for (const Eigen::Vector3d& corner : corners) {
    mesh.positions_m.push_back(Floats(corner));
    mesh.normals.push_back(Floats(normal));
  }
  mesh.triangles.push_back({first, first + 3, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 1});
}

core::TexturedMesh Empty(const core::ChangedObject& object, std::string name) {
  core::TexturedMesh mesh;
  mesh.name = std::move(name);
  mesh.revision = object.revision;
  mesh.offset_m = object.box.centre_m;
  return mesh;
}

}  // namespace

std::vector<core::TexturedMesh> BoxMeshes(const SurveyObjects& survey) {
  std::vector<core::TexturedMesh> meshes;
  for (std::size_t n = 0; n < survey.objects.size(); ++n) {
    const core::ChangedObject& object = survey.objects[n];
    const std::string name = MeshName(object, n);
    core::TexturedMesh pictured = Empty(object, name), plain = Empty(object, name + "_plain");
    std::array<bool, core::kBoxSides> has_picture{};
    if (const auto found = survey.textures.find(object.uid);
        found != survey.textures.end() && !found->second.atlas_jpeg.empty()) {
      const core::ObjectTextures& textures = found->second;
      pictured.texture_jpeg = textures.atlas_jpeg;
      for (const core::FaceTexture& face : textures.faces) {
        const auto side = static_cast<std::size_t>(face.side);
        if (std::exchange(has_picture[side], true)) continue;
        AddSide(pictured, object.box, side);
        for (const auto& [x, y] : face.corners_px)
          pictured.texture_coordinates.push_back({static_cast<float>(x / textures.width_px),
                                                  static_cast<float>(y / textures.height_px)});
      }
    }
    for (std::size_t side = 0; side < core::kBoxSides; ++side) {
      if (!has_picture[side]) AddSide(plain, object.box, side);
    }
    plain.colours.assign(plain.positions_m.size(), ClassColour(object.size_class));
    if (!pictured.triangles.empty()) meshes.push_back(std::move(pictured));
    if (!plain.triangles.empty()) meshes.push_back(std::move(plain));
  }
  return meshes;
}

}  // namespace kawara::gis
