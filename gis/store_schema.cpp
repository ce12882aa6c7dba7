#include "gis/store_schema.hpp"

#include <fcntl.h>
#include <ogrsf_frmts.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "gis/gdal_errors.hpp"
#include "gis/picture_folder.hpp"
#include "gis/schema.hpp"

namespace kawara::gis {
namespace {

/// QGIS looks for styles in this table, in GeoPackage and PostGIS alike; the columns are QGIS's.
constexpr const char* kStyleTable = "layer_styles";

constexpr auto kStyleFields = std::to_array<Field>({
    {"f_table_catalog", FieldType::kText, false},
    {"f_table_schema", FieldType::kText, false},
    {"f_table_name", FieldType::kText, false},
    {"f_geometry_column", FieldType::kText, false},
    {"styleName", FieldType::kText, false},
    {"styleQML", FieldType::kText, false},
    {"styleSLD", FieldType::kText, false},
    {"useAsDefault", FieldType::kFlag, false},
    {"description", FieldType::kText, false},
    {"owner", FieldType::kText, false},
    {"ui", FieldType::kText, false},
    {"update_time", FieldType::kTime, false},
});
/// The layers of a store and how QGIS shows them.
struct StoreLayers {
  std::span<const LayerSchema> layers;
  std::string (*style)(const std::string& layer);
};

constexpr LayerSchema kStyles{
    kStyleTable, "QGIS layer styles", GeometryKind::kNone, kStyleFields, "id", "", "", "id"};

/// What has come since the store was made; its rows do not know it.
core::Expected<void> AddLaterFields(OgrDataset& dataset, OGRLayer& layer,
                                    const LayerSchema& schema) {
  for (const Field& field : schema.fields) {
    if (!field.later || layer.GetLayerDefn()->GetFieldIndex(field.name) >= 0) continue;
    if (auto added = dataset.AddField(layer, field); !added) return added;
  }
  return {};
}

core::Expected<void> CheckShape(OGRLayer& layer, const LayerSchema& schema) {
  for (const Field& field : schema.fields) {
    if (layer.GetLayerDefn()->GetFieldIndex(field.name) < 0)
      return core::Fail(core::ErrorCode::kFormat,
                        std::string("layer ") + schema.name + " has no field " + field.name +
                            " (made by another program or version: name another store)");
  }
  return {};
}

core::Expected<void> AddIndexes(OgrDataset& dataset, const LayerSchema& schema) {
  const std::string table = schema.name;
  const auto index = [&](const char* unique, const char* suffix, const std::string& columns) {
    return dataset.Execute(std::string("CREATE ") + unique + "INDEX IF NOT EXISTS " + table +
                           suffix + " ON " + table + " (" + columns + ")");
  };
  auto made = index("UNIQUE ", "_key", schema.key);
  if (made && schema.index[0] != '\0') made = index("", "_order", schema.index);
  const bool timed =
      std::any_of(schema.fields.begin(), schema.fields.end(),
                  [](const Field& field) { return std::string_view(field.name) == "t_begin"; });
  if (made && timed) made = index("", "_begin", "t_begin");
  return made;
}

/// A default style for every layer that has none; a user's own stays.
core::Expected<void> AddStyle(OgrDataset& dataset, OGRLayer& styles, const LayerSchema& schema,
                              const std::string& qml) {
  if (qml.empty()) return {};
  const std::string table = SqlText(schema.name);
  const auto there = dataset.QueryInteger(std::string("SELECT count(*) AS n FROM ") + kStyleTable +
                                          " WHERE f_table_name = " + table);
  if (!there) return tl::unexpected(there.error());
  if (there->value_or(0) > 0) return {};
  std::string catalog;
  std::string schema_name;
  if (dataset.is_postgis()) {
    auto got = dataset.ForEach("SELECT current_database() AS c, current_schema() AS s",
                               [&](const OGRFeature& row) {
                                 catalog = row.GetFieldAsString(0);
                                 schema_name = row.GetFieldAsString(1);
                               });
    if (!got) return got;
  }
  const bool spatial = schema.geometry != GeometryKind::kNone;
  OGRFeature f(styles.GetLayerDefn());
  const auto set = [&f](int field, const std::string& value) { f.SetField(field, value.c_str()); };
  set(0, catalog);
  set(1, schema_name);
  set(2, schema.name);
  set(3, spatial ? "geom" : "");
  set(4, schema.name);
  set(5, qml);
  set(6, "");
  f.SetField(7, 1);
  set(8, schema.title);
  set(9, "");
  constexpr int kUtcFlag = 100;
  f.SetField(11, 1980, 1, 6, 0, 0, 0.0F, kUtcFlag);  // no wall clock in the store
  return dataset.Write(styles, f);
}

core::Expected<void> EnsureSchema(OgrDataset& dataset, const StoreLayers& store) {
  if (dataset.Layer(kStyleTable) == nullptr) {
    if (auto made = dataset.CreateLayer(kStyles); !made) return made;
  }
  OGRLayer* styles = dataset.Layer(kStyleTable);
  if (styles == nullptr)
    return core::Fail(core::ErrorCode::kIo, "layer_styles cannot be read back");
  if (auto same = CheckShape(*styles, kStyles); !same) styles = nullptr;  // somebody else's table
  for (const LayerSchema& schema : store.layers) {
    OGRLayer* layer = dataset.Layer(schema.name);
    core::Expected<void> done;
    if (layer == nullptr) {
      done = dataset.CreateLayer(schema);
    } else {
      done = AddLaterFields(dataset, *layer, schema);
      if (done) done = CheckShape(*layer, schema);
    }
    if (done) done = AddIndexes(dataset, schema);
    if (done && styles != nullptr)
      done = AddStyle(dataset, *styles, schema, store.style(schema.name));
    if (!done) return done;
  }
  return {};
}

core::Expected<void> EnsureSchemaAtOnce(OgrDataset& dataset, const StoreLayers& store) {
  if (auto begun = dataset.Begin(); !begun) return begun;
  auto done = EnsureSchema(dataset, store);
  if (done) done = dataset.Commit();
  if (!done) dataset.Rollback();
  return done;
}

core::Expected<void> SyncFile(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0 || ::fsync(fd) != 0) {
    const int number = errno;
    if (fd >= 0) ::close(fd);
    return tl::unexpected(core::ErrnoError("fsync " + path, number));
  }
  ::close(fd);
  return {};
}

core::Expected<void> CreateFile(const std::filesystem::path& path, const StoreLayers& store) {
  const std::filesystem::path folder = path.parent_path();
  if (auto made = MakeFolders(folder); !made) return made;
  const std::string temporary = (folder / ("." + path.filename().string() + ".new")).string();
  const auto clean = [&temporary] {
    for (const char* suffix : {"", "-journal", "-wal", "-shm"})
      std::remove((temporary + suffix).c_str());
  };
  clean();
  core::Expected<void> done;
  {
    auto dataset = OgrDataset::CreateGeoPackage(temporary);
    done = dataset ? EnsureSchemaAtOnce(*dataset, store) : tl::unexpected(dataset.error());
  }
  if (done) done = SyncFile(temporary);
  if (done && ::rename(temporary.c_str(), path.c_str()) != 0)
    done = tl::unexpected(core::ErrnoError("rename to " + path.string(), errno));
  if (!done) {
    clean();
    return done;
  }
  return SyncFolder(folder);
}

core::Expected<OgrDataset> OpenPostgis(const std::string& target) {
  auto dataset = OgrDataset::Open(target, false);
  if (!dataset) return dataset;
  const auto there =
      dataset->QueryInteger("SELECT count(*) AS n FROM pg_extension WHERE extname = 'postgis'");
  if (!there) return tl::unexpected(there.error());
  if (there->value_or(0) > 0) return dataset;
  if (auto made = dataset->Execute("CREATE EXTENSION postgis"); !made)
    return core::Fail(core::ErrorCode::kNotFound,
                      WithoutPassword(target) +
                          ": the database has no PostGIS (as its owner: CREATE EXTENSION postgis; "
                          "package postgresql-15-postgis-3): " +
                          made.error().message);
  return OgrDataset::Open(target, false);  // the driver looks for PostGIS when it opens
}

}  // namespace

core::Expected<OgrDataset> OpenStore(const std::string& target) {
  return OpenStore(target, Schema(), QmlStyle);
}

core::Expected<OgrDataset> OpenStore(const std::string& target, std::span<const LayerSchema> layers,
                                     std::string (*style)(const std::string& layer)) {
  const StoreLayers store{layers, style};
  const bool postgis = OgrDataset::IsPostgis(target);
  if (!postgis && !std::filesystem::exists(target)) {
    if (auto created = CreateFile(target, store); !created) return tl::unexpected(created.error());
  }
  auto dataset = postgis ? OpenPostgis(target) : OgrDataset::Open(target, false);
  if (!dataset) return dataset;
  if (auto ready = EnsureSchemaAtOnce(*dataset, store); !ready) {
    core::Error error = ready.error();
    if (error.message.find(WithoutPassword(target)) == std::string::npos)
      error.message = WithoutPassword(target) + ": " + error.message;
    return tl::unexpected(error);
  }
  return dataset;
}

}  // namespace kawara::gis
