#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/expected.hpp"
#include "gis/schema.hpp"

/// Polygons with attributes as a GeoPackage of their own, for other programs: reference models,
/// truth, results. Not part of the spatial temporal store.
namespace kawara::gis {

/// monostate: NULL.
using FieldValue = std::variant<std::monostate, bool, std::int64_t, double, std::string>;

struct PolygonFeature {
  /// Each a ring, not closed: longitude [deg], latitude [deg], ellipsoidal height [m]. Several make
  /// one MULTIPOLYGON Z: the faces of a box, say.
  std::vector<std::vector<Eigen::Vector3d>> faces_lon_lat_h;
  std::vector<FieldValue> values;  ///< one a field, in the layer's order
};

struct PolygonLayer {
  std::string name;  ///< of the table
  std::string title;
  std::vector<Field> fields;
  std::vector<PolygonFeature> features;
};

/// Writes all layers (EPSG:4326, longitude first) to a new file beside `path` and renames it over
/// what was there. kInvalidArgument: a feature with too few or too many values; else GDAL's answer.
core::Expected<void> WritePolygonFile(const std::string& path,
                                      std::span<const PolygonLayer> layers);

}  // namespace kawara::gis
