#include <string>

#include "gis/model/model_writers.hpp"
#include "gis/model/text.hpp"
#include "gis/model/whole_file.hpp"

namespace kawara::gis {

core::Expected<void> WritePlyMesh(const std::filesystem::path& path,
                                  std::span<const core::TexturedMesh> meshes,
                                  const core::Geodetic& origin) {
  std::size_t corners = 0, faces = 0;
  for (const auto& mesh : meshes) {
    if (auto good = CheckMesh(mesh); !good) return good;
    corners += mesh.positions_m.size();
    faces += mesh.triangles.size();
  }
  std::string file =
      "ply\nformat binary_little_endian 1.0\ncomment origin: " + OriginText(origin) +
      "\ncomment axes: x east, y north, z up of the origin's tangent plane, metres\nelement "
      "vertex " +
      std::to_string(corners) +
      "\nproperty double x\nproperty double y\nproperty double z\nproperty float nx\n"
      "property float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\n"
      "property uchar blue\nelement face " +
      std::to_string(faces) + "\nproperty list uchar int vertex_indices\nend_header\n";
  file.reserve(file.size() + corners * 39 + faces * 13);
  for (const auto& mesh : meshes) {
    for (std::size_t i = 0; i < mesh.positions_m.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k)
        AppendBytes(file, mesh.offset_m[static_cast<Eigen::Index>(k)] +
                              static_cast<double>(mesh.positions_m[i][k]));
      AppendBytes(file, mesh.normals.empty() ? std::array<float, 3>{} : mesh.normals[i]);
      AppendBytes(file, mesh.colours.empty() ? std::array<std::uint8_t, 3>{200, 200, 200}
                                             : mesh.colours[i]);
    }
  }
  std::int32_t base = 0;
  for (const auto& mesh : meshes) {
    for (const auto& t : mesh.triangles) {
      AppendBytes(file, std::uint8_t{3});
      for (const std::uint32_t i : t) AppendBytes(file, base + static_cast<std::int32_t>(i));
    }
    base += static_cast<std::int32_t>(mesh.positions_m.size());
  }
  return WriteWholeFile(path, file);
}

}  // namespace kawara::gis
