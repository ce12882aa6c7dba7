#include "gis/polygon_file.hpp"

#include <ogrsf_frmts.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "gis/ogr_dataset.hpp"

namespace kawara::gis {
namespace {

OGRMultiPolygon ToOgr(const PolygonFeature& feature) {
  OGRMultiPolygon polygons;
  for (const auto& face : feature.faces_lon_lat_h) {
    OGRLinearRing ring;
    for (const Eigen::Vector3d& p : face) ring.addPoint(p.x(), p.y(), p.z());
    ring.closeRings();
    OGRPolygon polygon;
    polygon.addRing(&ring);
    polygons.addGeometry(&polygon);
  }
  return polygons;
}

void SetField(OGRFeature& row, int field, const FieldValue& value) {
  struct Setter {
    OGRFeature& row;
    int field;
    void operator()(std::monostate) const { row.SetFieldNull(field); }
    void operator()(bool v) const { row.SetField(field, v ? 1 : 0); }
    void operator()(std::int64_t v) const { row.SetField(field, static_cast<GIntBig>(v)); }
    void operator()(double v) const { row.SetField(field, v); }
    void operator()(const std::string& v) const { row.SetField(field, v.c_str()); }
  };
  std::visit(Setter{row, field}, value);
}

core::Expected<void> WriteLayer(OgrDataset& dataset, const PolygonLayer& layer) {
  LayerSchema schema{};
  schema.name = layer.name.c_str();
  schema.title = layer.title.c_str();
  schema.geometry = GeometryKind::kMultiPolygonZ;
  schema.fields = layer.fields;
  if (auto made = dataset.CreateLayer(schema); !made) return made;
  OGRLayer* table = dataset.Layer(layer.name);
  if (table == nullptr)
    return core::Fail(core::ErrorCode::kIo, "layer " + layer.name + " cannot be read back");
  for (const PolygonFeature& feature : layer.features) {
    if (feature.values.size() != layer.fields.size())
      return core::Fail(core::ErrorCode::kInvalidArgument,
                        "layer " + layer.name + ": a feature with " +
                            std::to_string(feature.values.size()) + " values for " +
                            std::to_string(layer.fields.size()) + " fields");
    OGRFeature row(table->GetLayerDefn());
    for (std::size_t i = 0; i < feature.values.size(); ++i)
      SetField(row, static_cast<int>(i), feature.values[i]);
    const OGRMultiPolygon geometry = ToOgr(feature);
    row.SetGeometry(&geometry);
    if (auto written = dataset.Write(*table, row); !written) return written;
  }
  return {};
}

core::Expected<void> WriteAll(const std::string& path, std::span<const PolygonLayer> layers) {
  auto dataset = OgrDataset::CreateGeoPackage(path);
  if (!dataset) return tl::unexpected(dataset.error());
  if (auto begun = dataset->Begin(); !begun) return begun;
  for (const PolygonLayer& layer : layers) {
    if (auto written = WriteLayer(*dataset, layer); !written) {
      dataset->Rollback();
      return written;
    }
  }
  return dataset->Commit();
}

}  // namespace

core::Expected<void> WritePolygonFile(const std::string& path,
                                      std::span<const PolygonLayer> layers) {
  const std::filesystem::path target(path);
  const std::string temporary =
      (target.parent_path() / ("." + target.filename().string() + ".new")).string();
  const auto clean = [&temporary] {
    for (const char* suffix : {"", "-journal", "-wal", "-shm"})
      std::remove((temporary + suffix).c_str());
  };
  clean();  // of a run that was killed
  auto done = WriteAll(temporary, layers);
  if (done && std::rename(temporary.c_str(), path.c_str()) != 0)
    done = tl::unexpected(core::ErrnoError("rename to " + path, errno));
  if (!done) clean();
  return done;
}

}  // namespace kawara::gis
