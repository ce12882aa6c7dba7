#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/config/config.hpp"
#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "core/textured_mesh.hpp"

namespace kawara::mapper {

/// A finished tile, as model.yaml lists it. Its files are NAME.wrl, .glb, .ply and .las.
struct TileRecord {
  int x = 0, y = 0;  ///< vision::TileIndex
  std::string name;
  std::uint64_t revision = 0;  ///< of the voxels it was made from; grows with every change
  std::uint64_t faces = 0;     ///< 0: nothing there to show, and no files
  std::uint64_t bytes = 0;     ///< of its files together
  Eigen::Vector3d min_m = Eigen::Vector3d::Zero(), max_m = Eigen::Vector3d::Zero();

  template <class V>
  void Visit(V& v) {
    v("x", x);
    v("y", y);
    v("name", name);
    v("revision", revision);
    v("faces", faces);
    v("bytes", bytes);
    v("min_m", min_m);
    v("max_m", max_m);
  }
};

/// What must be the same when a run goes on from where another stopped.
struct ModelIdentity {
  std::string source;   ///< what the pictures come from
  std::string options;  ///< all that changes the voxels

  template <class V>
  void Visit(V& v) {
    v("source", source);
    v("options", options);
  }
};

/// model.yaml: what lies in the folder.
struct ModelManifest {
  ModelIdentity made_of;
  std::uint64_t stops_done = 0;
  std::uint64_t pairs_done = 0;
  std::uint64_t stops_of_source = 0;  ///< all it had when the model became complete; 0: it is not
  std::vector<double> origin_deg_m;   ///< latitude, longitude, ellipsoidal height; empty: local map
  std::vector<std::uint64_t> looks;   ///< stops whose pictures open tiles take their textures from
  std::vector<TileRecord> tiles;

  template <class V>
  void Visit(V& v) {
    using core::config::Optional;
    v("made_of", made_of);
    v("stops_done", stops_done);
    v("pairs_done", pairs_done);
    v("stops_of_source", stops_of_source);
    v("origin_deg_m", origin_deg_m, Optional{});
    v("looks", looks, Optional{});
    v("tiles", tiles, Optional{});
  }
};

/// The folder of a model that grows: tiles, an index for every kind of viewer, and model.yaml. Each
/// file is there whole or not at all, and the indexes name only tiles that are there, so that the
/// folder can be shown and sent at any moment. One thread.
class ModelStore {
 public:
  /// Where the map of the model in a folder lies; empty: there is none, or it lies nowhere.
  static std::optional<core::Geodetic> OriginOf(const std::filesystem::path& folder);
  /// Makes the folder, or goes on with what is in it. kInvalidArgument: the model there is made of
  /// something else. `fresh`: forgets what is there.
  static core::Expected<ModelStore> Open(const std::filesystem::path& folder,
                                         const ModelIdentity& identity,
                                         const std::optional<core::Geodetic>& origin, bool fresh);

  /// Writes a tile's files; an empty mesh is noted only.
  core::Expected<void> WriteTile(int x, int y, std::uint64_t revision, core::TexturedMesh mesh,
                                 std::span<const core::ColouredPoint> points);
  /// Makes model.wrl, tileset.json and model.yaml those of the tiles there are.
  core::Expected<void> WriteIndex(std::uint64_t stops_done, std::uint64_t pairs_done,
                                  std::uint64_t stops_of_source, std::vector<std::uint64_t> looks);

  const ModelManifest& manifest() const { return manifest_; }
  /// Null: this tile has never been finished.
  const TileRecord* Find(int x, int y) const;
  std::filesystem::path vrml() const { return folder_ / "model.wrl"; }
  std::filesystem::path voxels() const { return folder_ / "voxels.spill"; }

 private:
  ModelStore(std::filesystem::path folder, std::optional<core::Geodetic> origin)
      : folder_(std::move(folder)), origin_(origin) {}
  core::Expected<void> WriteFiles(const core::TexturedMesh& mesh,
                                  std::span<const core::ColouredPoint> points,
                                  TileRecord& record) const;
  void RemoveOldTextures(const std::string& name, std::uint64_t revision) const;

  std::filesystem::path folder_;
  std::optional<core::Geodetic> origin_;
  ModelManifest manifest_;
};

}  // namespace kawara::mapper
