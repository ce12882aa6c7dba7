#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "core/expected.hpp"
#include "gis/records.hpp"

namespace kawara::gis {

struct StoreConfig {
  /// A GeoPackage file ("out/mission.gpkg") or a PostGIS connection string of OGR
  /// ("PG:host=hq dbname=disaster user=kawara"). Everything after this line is the same code for
  /// both.
  std::string target;
  /// Folder of the JPEG files. Empty: "pictures" beside the GeoPackage, or in the working folder
  /// for PostGIS.
  std::filesystem::path pictures_dir = {};
  /// Rows and pictures taken in and not yet durable; Add* answers kFull beyond it.
  std::size_t max_pending_bytes = std::size_t{256} << 20;
};

/// What became of everything added, since Open.
struct StoreStats {
  std::uint64_t poses = 0;       ///< new rows
  std::uint64_t panoramas = 0;   ///< new rows
  std::uint64_t upgrades = 0;    ///< rows whose preview gave way to the full picture
  std::uint64_t events = 0;      ///< new rows
  std::uint64_t duplicates = 0;  ///< already there: ignored
  std::uint64_t commits = 0;
};

/// The spatial temporal store: layers obs_pose, obs_panorama, trajectory and event_log (schema.hpp)
/// in a GeoPackage or PostGIS, written by GDAL/OGR, and the pictures as files beside it.
///
/// What exists: a row exists over t_begin <= T < t_end, NULL is an open end (the rule QGIS filters
/// by). A pose or a picture exists until the next one of the same robot in its layer. A trajectory
/// spans its first to its last pose. Durable: what Flush() has returned for survives SIGKILL and
/// power cut; at any moment the store can be opened and every row's picture is there (temporary
/// file, fsync, rename, fsync of the folder, only then the row's commit). Pure: the rows are a
/// function of the SET of records added; neither the wall clock, nor their order, nor repetition,
/// nor how they were batched shows (DumpStore compares). Errors: Flush() either makes everything
/// added durable or nothing is acknowledged, all stays pending (bounded) and the next Flush() tries
/// again on a fresh connection: call it later for kFull (disk), kUnavailable (locked, server down).
/// One thread only.
class SpatioTemporalStore {
 public:
  /// Creates the store or opens it and its schema; also mends what a killed writer left (stale
  /// trajectories, temporary files). The message says what, where and how to mend.
  static core::Expected<SpatioTemporalStore> Open(const StoreConfig& config);
  ~SpatioTemporalStore();  ///< closes without flushing; call Close()
  SpatioTemporalStore(SpatioTemporalStore&&) noexcept;
  SpatioTemporalStore& operator=(SpatioTemporalStore&&) noexcept;

  /// Take a record in. kInvalidArgument: outside of what a row may hold (CheckRecord tells why);
  /// kFull: pending is full, nothing was taken.
  core::Expected<void> AddPose(const PoseRecord& pose);
  core::Expected<void> AddPanorama(const PanoramaRecord& panorama);
  core::Expected<void> AddEvent(const EventRecord& event);

  /// Makes everything added durable and visible.
  core::Expected<void> Flush();
  /// Flush, final trajectories, one tidy file (no -wal left beside it unless somebody else has it
  /// open).
  core::Expected<void> Close();

  std::size_t pending() const;  ///< records added and not yet durable
  const StoreStats& stats() const;
  const std::filesystem::path& pictures_dir() const;

 private:
  class Impl;
  explicit SpatioTemporalStore(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kawara::gis
