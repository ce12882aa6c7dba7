#include <algorithm>
#include <string>

#include "gis/model/model_writers.hpp"
#include "gis/model/text.hpp"
#include "gis/model/whole_file.hpp"

namespace kawara::gis {
namespace {

// OGC 22-025r4, 7.4.3: centre and three half axes.
std::string BoxOf(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  const Eigen::Vector3d centre = 0.5 * (low + high);
  const Eigen::Vector3d half = (0.5 * (high - low)).cwiseMax(0.001);
  std::string text = "{\"box\":[";
  for (const double v : centre) text += Number(v, 4) + ",";
  text += Number(half.x(), 4) + ",0,0,0," + Number(half.y(), 4) + ",0,0,0," + Number(half.z(), 4) +
          "]}";
  return text;
}

// Columns of the matrix that takes the origin's east, north, up to ECEF.
std::string TransformOf(const core::Geodetic& origin) {
  const double sl = std::sin(origin.lat_rad), cl = std::cos(origin.lat_rad);
  const double so = std::sin(origin.lon_rad), co = std::cos(origin.lon_rad);
  const Eigen::Vector3d at = core::EcefFromGeodetic(origin);
  std::string text = "[";
  for (const double v : {-so, co, 0.0, 0.0, -sl * co, -sl * so, cl, 0.0, cl * co, cl * so, sl, 0.0,
                         at.x(), at.y(), at.z()})
    text += Number(v, 15) + ",";
  return text + "1]";
}

}  // namespace

TileEntry EntryOf(const core::TexturedMesh& mesh, std::string uri) {
  TileEntry entry{std::move(uri), mesh.revision, mesh.offset_m, mesh.offset_m};
  for (std::size_t i = 0; i < mesh.positions_m.size(); ++i) {
    const auto& p = mesh.positions_m[i];
    const Eigen::Vector3d at = mesh.offset_m + Eigen::Vector3f(p[0], p[1], p[2]).cast<double>();
    entry.min_m = i == 0 ? at : Eigen::Vector3d(entry.min_m.cwiseMin(at));
    entry.max_m = i == 0 ? at : Eigen::Vector3d(entry.max_m.cwiseMax(at));
  }
  return entry;
}

core::Expected<void> WriteTileset(const std::filesystem::path& path,
                                  std::span<const TileEntry> tiles, const core::Geodetic& origin,
                                  double geometric_error_m) {
  if (tiles.empty())
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      path.string() + ": a tileset needs a tile at least");
  Eigen::Vector3d low = tiles.front().min_m, high = tiles.front().max_m;
  std::uint64_t revision = 0;
  std::string children;
  for (const TileEntry& tile : tiles) {
    const bool good_uri =
        !tile.uri.empty() && tile.uri.find_first_of("\"\\\n") == std::string::npos;
    if (!good_uri || !tile.min_m.allFinite() || !tile.max_m.allFinite())
      return core::Fail(core::ErrorCode::kInvalidArgument,
                        path.string() + ": a tile without a name or place");
    low = low.cwiseMin(tile.min_m);
    high = high.cwiseMax(tile.max_m);
    revision = std::max(revision, tile.revision);
    if (!children.empty()) children += ",\n    ";
    children += "{\"boundingVolume\":" + BoxOf(tile.min_m, tile.max_m) +
                ",\"geometricError\":0,\"content\":{\"uri\":\"" + tile.uri +
                "\"},\"extras\":{\"revision\":" + std::to_string(tile.revision) + "}}";
  }
  const std::string error = Number(geometric_error_m, 3);
  const std::string json =
      "{\"asset\":{\"version\":\"1.1\",\"tilesetVersion\":\"" + std::to_string(revision) +
      "\"},\n \"geometricError\":" + error +
      ",\n \"root\":{\n  \"transform\":" + TransformOf(origin) +
      ",\n  \"boundingVolume\":" + BoxOf(low, high) + ",\n  \"geometricError\":" + error +
      ",\n  \"refine\":\"ADD\",\n  \"children\":[\n    " + children + "\n  ]}}\n";
  return WriteWholeFile(path, json);
}

}  // namespace kawara::gis
