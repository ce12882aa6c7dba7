#include "vision/model/surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>

#include "vision/model/distance_field.hpp"

namespace kawara::vision {
namespace {

using Cell = std::array<int, 3>;

std::array<std::uint8_t, 3> ToBytes(const std::array<float, 3>& colour) {
  std::array<std::uint8_t, 3> bytes{};
  for (std::size_t c = 0; c < 3; ++c)
    bytes[c] = static_cast<std::uint8_t>(std::clamp(colour[c] + 0.5F, 0.0F, 255.0F));
  return bytes;
}

/// Grows a Surface; corners in voxels from the patch's first.
class Builder {
 public:
  Builder(const VoxelPatch& patch, double voxel_m, const TileIndex& tile) : patch_(patch) {
    voxel_m_ = static_cast<float>(voxel_m);
    surface_.mesh.name = "tile_" + std::to_string(tile.x) + "_" + std::to_string(tile.y);
    surface_.mesh.offset_m = Eigen::Vector3d(tile.x * kTileSide, tile.y * kTileSide, 0.0) * voxel_m;
    from_offset_ = {-static_cast<float>(VoxelPatch::kMargin),
                    -static_cast<float>(VoxelPatch::kMargin), static_cast<float>(patch.first().z)};
  }
  std::uint32_t AddCorner(const Eigen::Vector3f& at, const Eigen::Vector3f& normal,
                          const std::array<float, 3>& colour) {
    core::TexturedMesh& mesh = surface_.mesh;
    const Eigen::Vector3f p = (at + from_offset_) * voxel_m_;
    mesh.positions_m.push_back({p.x(), p.y(), p.z()});
    mesh.normals.push_back({normal.x(), normal.y(), normal.z()});
    mesh.colours.push_back(ToBytes(colour));
    return static_cast<std::uint32_t>(mesh.positions_m.size() - 1);
  }
  void AddQuad(const Quad& quad) {
    surface_.quads.push_back(quad);
    surface_.mesh.triangles.push_back({quad[0], quad[1], quad[2]});
    surface_.mesh.triangles.push_back({quad[0], quad[2], quad[3]});
  }
  const VoxelPatch& patch() const { return patch_; }
  Surface Take() { return std::move(surface_); }

 private:
  const VoxelPatch& patch_;
  float voxel_m_ = 0.0F;
  Eigen::Vector3f from_offset_;
  Surface surface_;
};

/// Corners of cells, made when a quad first needs them.
class Net {
 public:
  explicit Net(Builder& builder) : builder_(builder), field_(builder.patch()) {}

  /// The edge from lattice corner (x, y, z) one voxel along `axis`.
  void TryEdge(const Cell& low, int axis) {
    Cell high = low;
    ++high[static_cast<std::size_t>(axis)];
    // By value: the field may grow.
    const FieldSample a = field_.At(low[0], low[1], low[2]);
    const FieldSample b = field_.At(high[0], high[1], high[2]);
    if (!a.known() || !b.known() || (a.distance < 0.0F) == (b.distance < 0.0F)) return;
    // The four cells around it; right-handed about the axis.
    const auto u = static_cast<std::size_t>((axis + 1) % 3);
    const auto v = static_cast<std::size_t>((axis + 2) % 3);
    Quad quad{};
    constexpr std::array<std::array<int, 2>, 4> kAround{{{-1, -1}, {0, -1}, {0, 0}, {-1, 0}}};
    for (std::size_t i = 0; i < 4; ++i) {
      Cell cell = low;
      cell[u] += kAround[i][0];
      cell[v] += kAround[i][1];
      quad[i] = CornerOf(cell);
    }
    // Outside lies up the axis: counter-clockwise seen from there is as it stands.
    if (a.distance > b.distance) std::swap(quad[1], quad[3]);
    builder_.AddQuad(quad);
  }

 private:
  std::uint32_t CornerOf(const Cell& cell) {
    const auto side = static_cast<std::uint64_t>(builder_.patch().side());
    const std::uint64_t key =
        (static_cast<std::uint64_t>(cell[2]) * side + static_cast<std::uint64_t>(cell[1])) * side +
        static_cast<std::uint64_t>(cell[0]);
    const auto [found, is_new] = corners_.try_emplace(key, 0);
    if (!is_new) return found->second;
    Eigen::Vector3f at = Eigen::Vector3f::Zero(), normal = Eigen::Vector3f::Zero();
    std::array<float, 3> colour{};
    float crossings = 0.0F;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (int n = 0; n < 4; ++n) {
        Cell low = cell;
        low[(axis + 1) % 3] += n & 1;
        low[(axis + 2) % 3] += n >> 1;
        Cell high = low;
        ++high[axis];
        const FieldSample a = field_.At(low[0], low[1], low[2]);
        const FieldSample b = field_.At(high[0], high[1], high[2]);
        if (!a.known() || !b.known() || (a.distance < 0.0F) == (b.distance < 0.0F)) continue;
        const float t = a.distance / (a.distance - b.distance);
        Eigen::Vector3f crossing(static_cast<float>(low[0]), static_cast<float>(low[1]),
                                 static_cast<float>(low[2]));
        crossing[static_cast<Eigen::Index>(axis)] += t;
        at += crossing;
        normal += (1.0F - t) * a.normal + t * b.normal;
        for (std::size_t c = 0; c < 3; ++c) colour[c] += (1.0F - t) * a.colour[c] + t * b.colour[c];
        crossings += 1.0F;
      }
    }
    for (float& c : colour) c /= crossings;
    found->second = builder_.AddCorner(at / crossings, normal.normalized(), colour);
    return found->second;
  }

  Builder& builder_;
  DistanceField field_;
  std::unordered_map<std::uint64_t, std::uint32_t> corners_;
};

void BuildSmooth(Builder& builder) {
  const VoxelPatch& patch = builder.patch();
  Net net(builder);
  // Edges beside an occupied voxel, in order of the lattice; an edge belongs to the tile of its low
  // end.
  for (int z = 1; z + 1 < patch.height(); ++z) {
    for (int y = VoxelPatch::kMargin; y < VoxelPatch::kMargin + kTileSide; ++y) {
      for (int x = VoxelPatch::kMargin; x < VoxelPatch::kMargin + kTileSide; ++x) {
        // The voxels that touch the corner's three upward edges.
        const auto is_occupied = [&](int dx, int dy, int dz) {
          return patch.At(x + dx, y + dy, z + dz) != VoxelPatch::kNone;
        };
        const bool here = is_occupied(0, 0, 0);
        const bool x_back = is_occupied(-1, 0, 0), y_back = is_occupied(0, -1, 0),
                   z_back = is_occupied(0, 0, -1);
        if (here || y_back || z_back || is_occupied(0, -1, -1)) net.TryEdge({x, y, z}, 0);
        if (here || x_back || z_back || is_occupied(-1, 0, -1)) net.TryEdge({x, y, z}, 1);
        if (here || x_back || y_back || is_occupied(-1, -1, 0)) net.TryEdge({x, y, z}, 2);
      }
    }
  }
}

void BuildBlocky(Builder& builder) {
  const VoxelPatch& patch = builder.patch();
  for (const Surfel& s : patch.surfels()) {
    const Cell at{s.index.x - patch.first().x, s.index.y - patch.first().y,
                  s.index.z - patch.first().z};
    if (!VoxelPatch::IsInTile(at[0], at[1])) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const int side : {0, 1}) {
        Cell beside = at;
        beside[axis] += 2 * side - 1;
        if (patch.At(beside[0], beside[1], beside[2]) != VoxelPatch::kNone) continue;
        Eigen::Vector3f normal = Eigen::Vector3f::Zero();
        normal[static_cast<Eigen::Index>(axis)] = side == 1 ? 1.0F : -1.0F;
        Quad quad{};
        constexpr std::array<std::array<int, 2>, 4> kAround{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
        for (std::size_t i = 0; i < 4; ++i) {
          Cell corner = at;
          corner[axis] += side;
          corner[(axis + 1) % 3] += kAround[i][0];
          corner[(axis + 2) % 3] += kAround[i][1];
          quad[i] = builder.AddCorner({static_cast<float>(corner[0]), static_cast<float>(corner[1]),
                                       static_cast<float>(corner[2])},
                                      normal, s.colour);
        }
        if (side == 0) std::swap(quad[1], quad[3]);
        builder.AddQuad(quad);
      }
    }
  }
}

std::vector<core::ColouredPoint> PointsOf(const VoxelPatch& patch, double voxel_m) {
  const VoxelIndex& first = patch.first();
  const Eigen::Vector3d origin(first.x, first.y, first.z);
  std::vector<core::ColouredPoint> points;
  for (const Surfel& s : patch.surfels()) {
    if (!VoxelPatch::IsInTile(s.index.x - first.x, s.index.y - first.y)) continue;
    points.push_back({(origin + s.centroid.cast<double>()) * voxel_m, ToBytes(s.colour), s.hits});
  }
  return points;
}

}  // namespace

Surface BuildSurface(const VoxelMap& map, const TileIndex& tile, const SurfaceRule& rule,
                     SurfaceKind kind) {
  const VoxelPatch patch(map, tile, rule);
  Builder builder(patch, map.config().voxel_m, tile);
  if (!patch.surfels().empty()) {
    if (kind == SurfaceKind::kSmooth) {
      BuildSmooth(builder);
    } else {
      BuildBlocky(builder);
    }
  }
  Surface surface = builder.Take();
  surface.points = PointsOf(patch, map.config().voxel_m);
  surface.mesh.revision = map.Revision(tile);
  return surface;
}

}  // namespace kawara::vision
