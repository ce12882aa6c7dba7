#include "onboard/mapper/model_store.hpp"

#include <algorithm>
#include <utility>

#include "gis/model/model_writers.hpp"
#include "gis/model/whole_file.hpp"

namespace kawara::mapper {
namespace {

namespace fs = std::filesystem;
using core::ErrorCode;
using core::Fail;

constexpr const char* kManifest = "model.yaml";

/// What gis::WriteWholeFile leaves behind when it is killed.
void RemoveHalfFiles(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> half;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string file = entry.path().filename().string();
    const bool ours = file.starts_with(".tile") || file.starts_with(".model.");
    if (ours && file.ends_with(".tmp")) half.push_back(entry.path());
  }
  for (const fs::path& file : half) fs::remove(file, error);
}

}  // namespace

std::optional<core::Geodetic> ModelStore::OriginOf(const fs::path& folder) {
  const auto manifest = core::config::Load<ModelManifest>((folder / kManifest).string());
  if (!manifest || manifest->origin_deg_m.size() != 3) return {};
  const auto& origin = manifest->origin_deg_m;
  return core::Geodetic{origin[0] * core::kRadFromDeg, origin[1] * core::kRadFromDeg, origin[2]};
}

core::Expected<ModelStore> ModelStore::Open(const fs::path& folder, const ModelIdentity& identity,
                                            const std::optional<core::Geodetic>& origin,
                                            bool fresh) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return Fail(ErrorCode::kIo, "make folder " + folder.string() + ": " + error.message());
  }
  RemoveHalfFiles(folder);
  ModelStore store(folder, origin);
  const fs::path path = folder / kManifest;
  if (fresh) {
    // The manifest last: without it nothing in the folder counts.
    fs::remove(store.voxels(), error);
    fs::remove(path, error);
    if (error) {
      return Fail(ErrorCode::kIo, "remove " + path.string() + ": " + error.message());
    }
  }
  if (fs::exists(path, error)) {
    auto manifest = core::config::Load<ModelManifest>(path.string());
    if (!manifest) return tl::unexpected(manifest.error());
    const ModelIdentity& there = manifest->made_of;
    if (there.source != identity.source || there.options != identity.options) {
      return Fail(ErrorCode::kInvalidArgument,
                  folder.string() + " holds a model of " + there.source + " with " + there.options +
                      ", not of " + identity.source + " with " + identity.options +
                      ": take another --out, or --fresh to make it anew");
    }
    // Revisions are those of the voxels: without them the tiles there mean nothing.
    if (fs::exists(store.voxels(), error)) store.manifest_ = std::move(*manifest);
  } else if (fs::exists(store.voxels(), error)) {
    fs::remove(store.voxels(), error);  // a run that had not come to its first manifest
  }
  store.manifest_.made_of = identity;
  if (origin) {
    store.manifest_.origin_deg_m = {origin->lat_rad * core::kDegFromRad,
                                    origin->lon_rad * core::kDegFromRad, origin->h_ellipsoidal_m};
  }
  return store;
}

const TileRecord* ModelStore::Find(int x, int y) const {
  const auto found = std::ranges::find_if(
      manifest_.tiles, [&](const TileRecord& tile) { return tile.x == x && tile.y == y; });
  return found == manifest_.tiles.end() ? nullptr : &*found;
}

core::Expected<void> ModelStore::WriteTile(int x, int y, std::uint64_t revision,
                                           core::TexturedMesh mesh,
                                           std::span<const core::ColouredPoint> points) {
  TileRecord record{.x = x,
                    .y = y,
                    .name = "tile_" + std::to_string(x) + "_" + std::to_string(y),
                    .revision = revision};
  mesh.name = record.name;
  mesh.revision = revision;
  record.faces = mesh.triangles.size() / 2;
  if (!mesh.triangles.empty()) {
    if (auto done = WriteFiles(mesh, points, record); !done) return done;
  }
  std::erase_if(manifest_.tiles,
                [&](const TileRecord& tile) { return tile.x == x && tile.y == y; });
  const auto place =
      std::ranges::lower_bound(manifest_.tiles, std::pair(x, y), {},
                               [](const TileRecord& tile) { return std::pair(tile.x, tile.y); });
  manifest_.tiles.insert(place, std::move(record));
  return {};
}

core::Expected<void> ModelStore::WriteFiles(const core::TexturedMesh& mesh,
                                            std::span<const core::ColouredPoint> points,
                                            TileRecord& record) const {
  const std::span<const core::TexturedMesh> meshes(&mesh, 1);
  const core::Geodetic origin = origin_.value_or(core::Geodetic{});
  const std::string base = (folder_ / mesh.name).string();
  if (auto done = gis::WriteVrml(base + ".wrl", meshes, origin); !done) return done;
  RemoveOldTextures(mesh.name, mesh.revision);
  if (auto done = gis::WriteGlb(base + ".glb", meshes, origin); !done) return done;
  if (auto done = gis::WritePlyMesh(base + ".ply", meshes, origin); !done) return done;
  if (origin_) {
    if (auto done = gis::WriteLas(base + ".las", points, origin); !done) return done;
  }
  std::error_code error;
  for (const char* kind : {".wrl", ".glb", ".ply", ".las"}) {
    const auto bytes = fs::file_size(base + kind, error);
    if (!error) record.bytes += bytes;
  }
  const gis::TileEntry entry = gis::EntryOf(mesh, mesh.name + ".glb");
  record.min_m = entry.min_m;
  record.max_m = entry.max_m;
  return {};
}

void ModelStore::RemoveOldTextures(const std::string& name, std::uint64_t revision) const {
  const std::string kept = name + "_r" + std::to_string(revision) + ".jpg";
  std::error_code error;
  std::vector<fs::path> old;
  for (const auto& entry : fs::directory_iterator(folder_, error)) {
    const std::string file = entry.path().filename().string();
    if (file.starts_with(name + "_r") && file.ends_with(".jpg") && file != kept) {
      old.push_back(entry.path());
    }
  }
  for (const fs::path& file : old) fs::remove(file, error);
}

core::Expected<void> ModelStore::WriteIndex(std::uint64_t stops_done, std::uint64_t pairs_done,
                                            std::uint64_t stops_of_source,
                                            std::vector<std::uint64_t> looks) {
  manifest_.looks = std::move(looks);
  manifest_.stops_done = stops_done;
  manifest_.pairs_done = pairs_done;
  manifest_.stops_of_source = stops_of_source;
  std::string text = "#VRML V2.0 utf8\n";
  std::vector<gis::TileEntry> entries;
  for (const TileRecord& tile : manifest_.tiles) {
    if (tile.faces == 0) continue;
    text += "Inline { url \"" + tile.name + ".wrl\" }\n";
    entries.push_back({tile.name + ".glb", tile.revision, tile.min_m, tile.max_m});
  }
  if (!entries.empty()) {
    if (auto done = gis::WriteWholeFile(vrml(), text); !done) return done;
    if (origin_) {
      const auto done = gis::WriteTileset(folder_ / "tileset.json", entries, *origin_);
      if (!done) return done;
    }
  }
  return gis::WriteWholeFile(folder_ / kManifest, core::config::Dump(manifest_));
}

}  // namespace kawara::mapper
