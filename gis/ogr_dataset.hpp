#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/expected.hpp"
#include "gis/schema.hpp"

class GDALDataset;
class OGRFeature;
class OGRLayer;

namespace kawara::gis {

/// Thin owner of one GDAL vector dataset: every failure of GDAL comes back as one line, none is
/// printed. Inside gis/ only. GeoPackages run in WAL mode with synchronous FULL (a returned Commit
/// is on the disk; readers such as QGIS do not block us, nor we them); PostGIS commits as its
/// server is set up (durable by default). One thread only.
class OgrDataset {
 public:
  /// "PG:..." is PostGIS, anything else a GeoPackage file.
  static bool IsPostgis(const std::string& target) { return target.rfind("PG:", 0) == 0; }
  static core::Expected<OgrDataset> Open(const std::string& target, bool read_only);
  /// A new GeoPackage file without layers. The folder must exist.
  static core::Expected<OgrDataset> CreateGeoPackage(const std::string& path);

  OgrDataset(OgrDataset&&) noexcept;
  OgrDataset& operator=(OgrDataset&&) noexcept;
  ~OgrDataset();  ///< closes; errors are swallowed (what was committed is safe)

  bool is_postgis() const { return is_postgis_; }
  OGRLayer* Layer(const std::string& name);  ///< null: there is none
  /// Table, geometry column, spatial index; the schema's other indexes are made by store_schema.
  core::Expected<void> CreateLayer(const LayerSchema& schema);
  /// To a layer that has rows, which hold NULL there, whatever the field requires.
  core::Expected<void> AddField(OGRLayer& layer, const Field& field);

  core::Expected<void> Begin();
  core::Expected<void> Commit();
  void Rollback();

  core::Expected<void> Execute(const std::string& sql);
  /// First column of the first row; nullopt: no row, or NULL.
  core::Expected<std::optional<std::int64_t>> QueryInteger(const std::string& sql);
  /// Calls `row` for every row of a SELECT.
  core::Expected<void> ForEach(const std::string& sql,
                               const std::function<void(const OGRFeature&)>& row);
  /// Creates the feature, or overwrites the one with its FID if it has one.
  core::Expected<void> Write(OGRLayer& layer, OGRFeature& feature);
  /// Brings extent and change stamp (the newest `time_column`) of a layer in the GeoPackage's table
  /// of contents up to date; nothing to do in PostGIS.
  core::Expected<void> Sync(OGRLayer& layer, const std::string& time_column);

 private:
  OgrDataset(GDALDataset* dataset, const std::string& target);
  static void TakeInJournal(const std::string& path);
  core::Error Classify(const std::string& doing, const std::string& gdal_message) const;

  struct Closer {
    void operator()(GDALDataset* dataset) const;
  };
  std::unique_ptr<GDALDataset, Closer> dataset_;
  std::string target_;  ///< without a password
  bool is_postgis_ = false;
};

}  // namespace kawara::gis
