#include <string>

#include "gis/model/model_writers.hpp"
#include "gis/model/text.hpp"
#include "gis/model/whole_file.hpp"

namespace kawara::gis {
namespace {

template <std::size_t N>
void AppendRow(std::string& text, const std::array<double, N>& row, int decimals) {
  for (std::size_t i = 0; i < N; ++i) {
    AppendNumber(text, row[i], decimals);
    text += i + 1 < N ? " " : ",\n";
  }
}

std::string TextureName(const core::TexturedMesh& mesh) {
  return mesh.name + "_r" + std::to_string(mesh.revision) + ".jpg";
}

void AppendShape(std::string& text, const core::TexturedMesh& mesh) {
  const bool textured = !mesh.texture_jpeg.empty();
  text += "    DEF " + mesh.name + " Transform {\n      translation ";
  AppendNumber(text, mesh.offset_m.x(), 4);
  text += ' ';
  AppendNumber(text, mesh.offset_m.y(), 4);
  text += ' ';
  AppendNumber(text, mesh.offset_m.z(), 4);
  text += "\n      children Shape {\n        appearance Appearance {\n";
  // No Material: lamps do not count (ISO 14772-1, 4.14.4), pictures have their own light.
  if (textured) text += "          texture ImageTexture { url \"" + TextureName(mesh) + "\" }\n";
  text += "        }\n        geometry IndexedFaceSet {\n          solid FALSE\n";
  text += "          coord Coordinate { point [\n";
  for (const auto& p : mesh.positions_m)
    AppendRow<3>(
        text, {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])}, 4);
  text += "          ] }\n          coordIndex [\n";
  for (const auto& t : mesh.triangles)
    text +=
        std::to_string(t[0]) + "," + std::to_string(t[1]) + "," + std::to_string(t[2]) + ",-1,\n";
  text += "          ]\n";
  if (textured) {
    text += "          texCoord TextureCoordinate { point [\n";
    // VRML counts from the picture's lower left.
    for (const auto& t : mesh.texture_coordinates)
      AppendRow<2>(text, {static_cast<double>(t[0]), 1.0 - static_cast<double>(t[1])}, 6);
    text += "          ] }\n";
  } else if (!mesh.colours.empty()) {
    text += "          color Color { color [\n";
    for (const auto& c : mesh.colours)
      AppendRow<3>(text, {c[0] / 255.0, c[1] / 255.0, c[2] / 255.0}, 3);
    text += "          ] }\n";
  }
  if (!mesh.normals.empty()) {
    text += "          normal Normal { vector [\n";
    for (const auto& n : mesh.normals)
      AppendRow<3>(
          text, {static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2])},
          3);
    text += "          ] }\n";
  }
  text += "        }\n      }\n    }\n";
}

}  // namespace

core::Expected<void> WriteVrml(const std::filesystem::path& path,
                               std::span<const core::TexturedMesh> meshes,
                               const core::Geodetic& origin) {
  std::string text = "#VRML V2.0 utf8\n";
  text += "WorldInfo {\n  title \"Kawaraban 2nd update\"\n  info [\n    \"origin: " +
          OriginText(origin) +
          "\",\n    \"axes: X east, Y up, Z south of the origin's tangent plane, metres\"";
  for (const auto& mesh : meshes)
    text += ",\n    \"" + mesh.name + " revision " + std::to_string(mesh.revision) + "\"";
  text += "\n  ]\n}\nNavigationInfo { headlight TRUE type [ \"EXAMINE\", \"ANY\" ] }\n";
  // From east, north, up to VRML's axes.
  text += "Transform {\n  rotation 1 0 0 -1.5707963268\n  children [\n";
  for (const auto& mesh : meshes) {
    if (auto good = CheckMesh(mesh); !good) return good;
    if (!mesh.triangles.empty()) AppendShape(text, mesh);
  }
  text += "  ]\n}\n";
  for (const auto& mesh : meshes) {
    if (mesh.texture_jpeg.empty() || mesh.triangles.empty()) continue;
    const std::string_view jpeg(reinterpret_cast<const char*>(mesh.texture_jpeg.data()),
                                mesh.texture_jpeg.size());
    if (auto done = WriteWholeFile(path.parent_path() / TextureName(mesh), jpeg); !done)
      return done;
  }
  return WriteWholeFile(path, text);
}

}  // namespace kawara::gis
