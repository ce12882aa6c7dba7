#include "gis/ogr_dataset.hpp"

#include <cpl_conv.h>
#include <gdal_priv.h>
#include <ogrsf_frmts.h>

#include <filesystem>
#include <mutex>
#include <utility>

#include "gis/gdal_errors.hpp"

namespace kawara::gis {
namespace {

void RegisterDrivers() {
  static std::once_flag once;
  std::call_once(once, [] {
    // COPY, the PostgreSQL driver's bulk path, reports errors late and knows no row numbers.
    CPLSetConfigOption("PG_USE_COPY", "NO");
    // A lock of another program is waited for by the caller's retry, not in here.
    CPLSetConfigOption("SQLITE_BUSY_TIMEOUT", "1000");
    // GDAL's own change stamps must not show the wall clock; Sync() writes the data's time.
    CPLSetConfigOption("OGR_CURRENT_DATE", "1980-01-06T00:00:00.000Z");
    GDALAllRegister();
  });
}

OGRFieldType OgrType(FieldType type) {
  switch (type) {
    case FieldType::kInteger:
      return OFTInteger64;
    case FieldType::kFlag:
      return OFTInteger;
    case FieldType::kReal:
      return OFTReal;
    case FieldType::kTime:
      return OFTDateTime;
    case FieldType::kText:
      break;
  }
  return OFTString;
}

OGRwkbGeometryType OgrType(GeometryKind kind) {
  switch (kind) {
    case GeometryKind::kPoint:
      return wkbPoint;
    case GeometryKind::kPointZ:
      return wkbPoint25D;
    case GeometryKind::kLineString:
      return wkbLineString;
    case GeometryKind::kLineStringZ:
      return wkbLineString25D;
    case GeometryKind::kLineStringZm:
      return wkbLineStringZM;
    case GeometryKind::kPolygonZ:
      return wkbPolygon25D;
    case GeometryKind::kMultiPolygonZ:
      return wkbMultiPolygon25D;
    case GeometryKind::kNone:
      break;
  }
  return wkbNone;
}

}  // namespace

void OgrDataset::Closer::operator()(GDALDataset* dataset) const {
  const GdalErrorCatcher errors;
  GDALClose(dataset);
}

OgrDataset::OgrDataset(GDALDataset* dataset, const std::string& target)
    : dataset_(dataset), target_(WithoutPassword(target)), is_postgis_(IsPostgis(target)) {}
OgrDataset::OgrDataset(OgrDataset&&) noexcept = default;
OgrDataset& OgrDataset::operator=(OgrDataset&&) noexcept = default;
OgrDataset::~OgrDataset() = default;

core::Error OgrDataset::Classify(const std::string& doing, const std::string& gdal_message) const {
  return ErrorFromGdal(target_, doing, gdal_message);
}

// A writer that was killed leaves its last commits in a journal beside the file. SQLite takes them
// in when the file is opened for writing, and refuses to read without; a reader therefore opens it
// once to write. Where that is not allowed, the reader's own attempt tells.
void OgrDataset::TakeInJournal(const std::string& path) {
  const auto beside = [&path](const char* suffix) {
    std::error_code ignored;
    return std::filesystem::exists(path + suffix, ignored);
  };
  if (!beside("-wal") && !beside("-journal")) return;
  if (auto dataset = Open(path, false); dataset) {
    (void)dataset->Execute("SELECT count(*) FROM sqlite_master");
  }
}

core::Expected<OgrDataset> OgrDataset::Open(const std::string& target, bool read_only) {
  RegisterDrivers();
  const GdalErrorCatcher errors;
  const bool postgis = IsPostgis(target);
  if (!postgis && !std::filesystem::exists(target))
    return core::Fail(core::ErrorCode::kNotFound, target + ": no such file");
  if (!postgis && read_only) TakeInJournal(target);
  const char* const drivers[] = {postgis ? "PostgreSQL" : "GPKG", nullptr};
  const unsigned flags = static_cast<unsigned>(GDAL_OF_VECTOR) |
                         static_cast<unsigned>(read_only ? GDAL_OF_READONLY : GDAL_OF_UPDATE);
  GDALDataset* raw = GDALDataset::Open(target.c_str(), flags, drivers, nullptr, nullptr);
  if (raw == nullptr) {
    const std::string said =
        errors.message().empty() ? "not recognized as a supported file format" : errors.message();
    return tl::unexpected(ErrorFromGdal(WithoutPassword(target), "open", said));
  }
  OgrDataset dataset(raw, target);
  core::Expected<void> set;
  if (postgis) {
    set = dataset.Execute("SET TIME ZONE 'UTC'");
  } else if (!read_only) {
    set = dataset.Execute("PRAGMA journal_mode = WAL");
    if (set) set = dataset.Execute("PRAGMA synchronous = FULL");
  }
  if (!set) return tl::unexpected(set.error());
  return dataset;
}

core::Expected<OgrDataset> OgrDataset::CreateGeoPackage(const std::string& path) {
  RegisterDrivers();
  const GdalErrorCatcher errors;
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GPKG");
  if (driver == nullptr)
    return core::Fail(core::ErrorCode::kNotFound, "GDAL has no GeoPackage driver (libgdal32)");
  GDALDataset* raw = driver->Create(path.c_str(), 0, 0, 0, GDT_Unknown, nullptr);
  if (raw == nullptr) return tl::unexpected(ErrorFromGdal(path, "create", errors.message()));
  return OgrDataset(raw, path);
}

OGRLayer* OgrDataset::Layer(const std::string& name) {
  const GdalErrorCatcher errors;
  return dataset_->GetLayerByName(name.c_str());
}

core::Expected<void> OgrDataset::CreateLayer(const LayerSchema& schema) {
  const GdalErrorCatcher errors;
  OGRSpatialReference wgs84;
  wgs84.SetWellKnownGeogCS("WGS84");
  wgs84.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  CPLStringList options;
  options.SetNameValue("GEOMETRY_NAME", "geom");
  options.SetNameValue("FID", schema.fid);
  options.SetNameValue("DESCRIPTION", schema.title);
  options.SetNameValue("SPATIAL_INDEX", is_postgis_ ? "GIST" : "YES");
  const std::string doing = std::string("create layer ") + schema.name;
  OGRLayer* layer =
      dataset_->CreateLayer(schema.name, schema.geometry == GeometryKind::kNone ? nullptr : &wgs84,
                            OgrType(schema.geometry), options.List());
  if (layer == nullptr) return tl::unexpected(Classify(doing, errors.message()));
  for (const Field& field : schema.fields) {
    OGRFieldDefn definition(field.name, OgrType(field.type));
    if (field.type == FieldType::kFlag) definition.SetSubType(OFSTBoolean);
    definition.SetNullable(field.required ? FALSE : TRUE);
    if (layer->CreateField(&definition) != OGRERR_NONE)
      return tl::unexpected(Classify(doing, errors.message()));
  }
  layer->SyncToDisk();
  if (errors.failed()) return tl::unexpected(Classify(doing, errors.message()));
  return {};
}

core::Expected<void> OgrDataset::AddField(OGRLayer& layer, const Field& field) {
  const GdalErrorCatcher errors;
  OGRFieldDefn definition(field.name, OgrType(field.type));
  if (field.type == FieldType::kFlag) definition.SetSubType(OFSTBoolean);
  if (layer.CreateField(&definition) != OGRERR_NONE || errors.failed())
    return tl::unexpected(
        Classify(std::string("add ") + field.name + " to " + layer.GetName(), errors.message()));
  return {};
}

core::Expected<void> OgrDataset::Begin() {
  const GdalErrorCatcher errors;
  if (dataset_->StartTransaction(FALSE) != OGRERR_NONE)
    return tl::unexpected(Classify("begin", errors.message()));
  return {};
}

core::Expected<void> OgrDataset::Commit() {
  const GdalErrorCatcher errors;
  if (dataset_->CommitTransaction() != OGRERR_NONE || errors.failed())
    return tl::unexpected(Classify("commit", errors.message()));
  return {};
}

void OgrDataset::Rollback() {
  const GdalErrorCatcher errors;
  dataset_->RollbackTransaction();
}

core::Expected<void> OgrDataset::ForEach(const std::string& sql,
                                         const std::function<void(const OGRFeature&)>& row) {
  const GdalErrorCatcher errors;
  OGRLayer* result = dataset_->ExecuteSQL(sql.c_str(), nullptr, nullptr);
  if (result != nullptr) {
    while (const OGRFeatureUniquePtr feature{result->GetNextFeature()}) row(*feature);
    dataset_->ReleaseResultSet(result);
  }
  if (errors.failed())
    return tl::unexpected(Classify(sql.substr(0, sql.find(' ')), errors.message()));
  return {};
}

core::Expected<void> OgrDataset::Execute(const std::string& sql) {
  return ForEach(sql, [](const OGRFeature&) {});
}

core::Expected<std::optional<std::int64_t>> OgrDataset::QueryInteger(const std::string& sql) {
  std::optional<std::int64_t> answer;
  auto done = ForEach(sql, [&answer](const OGRFeature& feature) {
    if (!answer && feature.GetFieldCount() > 0 && feature.IsFieldSetAndNotNull(0))
      answer = feature.GetFieldAsInteger64(0);
  });
  if (!done) return tl::unexpected(done.error());
  return answer;
}

core::Expected<void> OgrDataset::Write(OGRLayer& layer, OGRFeature& feature) {
  const GdalErrorCatcher errors;
  const bool insert = feature.GetFID() == OGRNullFID;
  const OGRErr result = insert ? layer.CreateFeature(&feature) : layer.SetFeature(&feature);
  if (result != OGRERR_NONE || errors.failed())
    return tl::unexpected(Classify(std::string("write to ") + layer.GetName(), errors.message()));
  return {};
}

core::Expected<void> OgrDataset::Sync(OGRLayer& layer, const std::string& time_column) {
  if (is_postgis_) return {};
  const std::string table = layer.GetName();
  {
    const GdalErrorCatcher errors;
    layer.SyncToDisk();
    if (errors.failed()) return tl::unexpected(Classify("table of contents", errors.message()));
  }
  return Execute("UPDATE gpkg_contents SET last_change = coalesce((SELECT max(" + time_column +
                 ") FROM " + table + "), last_change) WHERE table_name = " + SqlText(table));
}

}  // namespace kawara::gis
