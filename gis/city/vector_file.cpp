#include "gis/city/vector_file.hpp"

#include <gdal_priv.h>
#include <ogrsf_frmts.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>

#include "gis/gdal_errors.hpp"

namespace kawara::gis {
namespace {

using Eigen::Vector3d;

tl::unexpected<core::Error> Refuse(const std::string& path, const std::string& what) {
  return core::Fail(core::ErrorCode::kInvalidArgument, path + ": " + what);
}

/// GeoJSON without a reference system is degrees by its standard; metres betray themselves.
bool CannotBeDegrees(OGRLayer& layer) {
  OGREnvelope box;
  return layer.GetExtent(&box, TRUE) == OGRERR_NONE &&
         (box.MinX < -360.0 || box.MaxX > 360.0 || box.MinY < -90.0 || box.MaxY > 90.0);
}

core::Expected<void> VisitLayer(const std::string& path, OGRLayer& layer, const MapFrame& frame,
                                const std::function<void(const VectorFeature&)>& visit) {
  std::optional<CrsToEnu> crs;
  if (frame.coordinates == Coordinates::kFromFile) {
    const OGRSpatialReference* reference = layer.GetSpatialRef();
    if (reference == nullptr || reference->IsEmpty())
      return Refuse(path, std::string("layer ") + layer.GetName() +
                              " states no reference system (is its .prj missing? else say that its "
                              "coordinates are local metres)");
    if (reference->IsGeographic() && CannotBeDegrees(layer))
      return Refuse(path, std::string("layer ") + layer.GetName() +
                              " has numbers that are no longitudes and latitudes: say that its "
                              "coordinates are local metres");
    auto made = CrsToEnu::Make(*reference, frame);
    if (!made) return core::Fail(made.error().code, path + ": " + made.error().message);
    crs.emplace(std::move(*made));
  }
  const auto place = [&crs](double x, double y, double z) -> Vector3d {
    return crs ? crs->Exact({x, y, z}) : Vector3d(x, y, z);
  };
  layer.ResetReading();
  while (const OGRFeatureUniquePtr row{layer.GetNextFeature()}) {
    if (const OGRGeometry* geometry = row->GetGeometryRef(); geometry != nullptr)
      visit({*row, *geometry, place, crs ? crs->heights() : HeightDatum::kUnknown});
  }
  return {};
}

}  // namespace

core::Expected<void> ForEachFeature(const std::string& path, const std::string& layer,
                                    const MapFrame& frame,
                                    const std::function<void(const VectorFeature&)>& visit) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored))
    return core::Fail(core::ErrorCode::kNotFound, path + ": no such file");
  RegisterGdal();
  const GdalErrorCatcher errors;
  const std::unique_ptr<GDALDataset> dataset{GDALDataset::Open(
      path.c_str(), static_cast<unsigned>(GDAL_OF_VECTOR) | static_cast<unsigned>(GDAL_OF_READONLY),
      nullptr, nullptr, nullptr)};
  if (!dataset)
    return core::Fail(core::ErrorCode::kFormat,
                      path + ": is no vector file GDAL can read" +
                          (errors.message().empty() ? "" : ": " + errors.message()));
  std::string names;
  bool found = false;
  for (OGRLayer* each : dataset->GetLayers()) {
    names += (names.empty() ? "" : ", ") + std::string(each->GetName());
    if (!layer.empty() && layer != each->GetName()) continue;
    if (layer.empty() && each->GetGeomType() == wkbNone) continue;
    found = true;
    if (auto done = VisitLayer(path, *each, frame, visit); !done) return done;
  }
  if (!found && !layer.empty())
    return Refuse(path, "no layer " + layer + " (it has: " + names + ")");
  if (errors.failed()) return core::Fail(core::ErrorCode::kFormat, path + ": " + errors.message());
  return {};
}

std::string TextOf(const OGRFeature& row, const std::vector<std::string>& fields) {
  for (const std::string& field : fields) {
    const int index = row.GetFieldIndex(field.c_str());
    if (index >= 0 && row.IsFieldSetAndNotNull(index)) return row.GetFieldAsString(index);
  }
  return "";
}

bool IsCityGml(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string head(16'384, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  return head.find("<") != std::string::npos && head.find("CityModel") != std::string::npos &&
         head.find("http://www.opengis.net/citygml/") != std::string::npos;
}

}  // namespace kawara::gis
