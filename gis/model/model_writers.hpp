#pragma once
#include <filesystem>
#include <span>
#include <string>

#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "core/textured_mesh.hpp"

namespace kawara::gis {

// Writers of the 2nd update's model. All write whole files or none (whole_file.hpp) and answer with
// its errors, or kInvalidArgument for a mesh that contradicts itself (CheckMesh). The same model
// gives the same bytes. `origin` is where the map's local east-north-up frame stands.

/// Every array as long as it must be, every index within, every number finite.
core::Expected<void> CheckMesh(const core::TexturedMesh& mesh);

/// VRML97 (ISO/IEC 14772-1), the paper's format: a Shape with IndexedFaceSet, TextureCoordinate and
/// ImageTexture for each mesh; WorldInfo says where the origin lies. VRML's Y is up, X east, Z
/// south. Textures become files beside it, NAME_rREVISION.jpg, written before it.
core::Expected<void> WriteVrml(const std::filesystem::path& path,
                               std::span<const core::TexturedMesh> meshes,
                               const core::Geodetic& origin);

/// glTF 2.0 binary: one mesh a node, textures inside. glTF's Y is up: the root node turns the map.
core::Expected<void> WriteGlb(const std::filesystem::path& path,
                              std::span<const core::TexturedMesh> meshes,
                              const core::Geodetic& origin);

/// Binary little-endian PLY with normals and colours, all meshes in one, in the map's frame
/// (double, as floats would not hold a long drive).
core::Expected<void> WritePlyMesh(const std::filesystem::path& path,
                                  std::span<const core::TexturedMesh> meshes,
                                  const core::Geodetic& origin);

/// LAS 1.4, point format 7, in WGS 84 / UTM of the origin's zone (stated as WKT; heights above the
/// ellipsoid), millimetres. Intensity holds the votes. Not within the polar caps
/// (kInvalidArgument).
core::Expected<void> WriteLas(const std::filesystem::path& path,
                              std::span<const core::ColouredPoint> points,
                              const core::Geodetic& origin);

/// A tile of a tileset: one GLB and where it lies.
struct TileEntry {
  std::string uri;  ///< relative to the tileset
  std::uint64_t revision = 0;
  Eigen::Vector3d min_m = Eigen::Vector3d::Zero();  ///< map frame
  Eigen::Vector3d max_m = Eigen::Vector3d::Zero();
};
/// Bounds of a mesh for that.
TileEntry EntryOf(const core::TexturedMesh& mesh, std::string uri);

/// 3D Tiles 1.1 tileset.json over GLBs written by WriteGlb. `geometric_error_m`: by how much a
/// viewer is wrong who does not load a tile.
core::Expected<void> WriteTileset(const std::filesystem::path& path,
                                  std::span<const TileEntry> tiles, const core::Geodetic& origin,
                                  double geometric_error_m = 5.0);

}  // namespace kawara::gis
