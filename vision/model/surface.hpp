#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "core/textured_mesh.hpp"
#include "vision/model/voxel_patch.hpp"

namespace kawara::vision {

enum class SurfaceKind : std::uint8_t {
  kSmooth,  ///< through the votes
  kBlocky,  ///< faces of the voxels, as the paper's figures show them
};

/// Four corners, counter-clockwise from outside; into TexturedMesh::positions_m.
using Quad = std::array<std::uint32_t, 4>;

/// The surface of one tile before it has a texture: each quad is the triangles (0, 1, 2), (0, 2,
/// 3).
struct Surface {
  core::TexturedMesh mesh;  ///< positions, normals, colours and triangles (two a quad)
  std::vector<Quad> quads;
  std::vector<core::ColouredPoint> points;  ///< mean votes of the voxels it is made of, in the map
};

/// Surface of a tile from its voxels. Nothing is closed by invention: where no voxel is occupied
/// there is no surface, and it ends where the votes end. Neighbouring tiles meet in the same
/// corners.
///
/// kSmooth: at the corners of the voxel lattice stands the signed distance to the planes of the
/// occupied voxels around, each with the weight of its votes (implicit moving least squares; Hoppe
/// et al., "Surface reconstruction from unorganized points", 1992, with averaging). Each cell where
/// it changes sign gets one corner at the mean of the crossings of its edges, and each edge that is
/// crossed a quad between the four cells around it (Gibson, "Constrained elastic surface nets",
/// 1998, without the relaxation). An edge counts only beside an occupied voxel.
Surface BuildSurface(const VoxelMap& map, const TileIndex& tile, const SurfaceRule& rule,
                     SurfaceKind kind = SurfaceKind::kSmooth);

}  // namespace kawara::vision
