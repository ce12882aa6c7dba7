#pragma once
#include <functional>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "gis/frame/crs_to_enu.hpp"

class OGRFeature;
class OGRGeometry;

namespace kawara::gis {

/// A feature of a vector file. place() takes the file's coordinates to the map.
struct VectorFeature {
  const OGRFeature& row;
  const OGRGeometry& geometry;
  std::function<Eigen::Vector3d(double x, double y, double z)> place;
  HeightDatum heights = HeightDatum::kUnknown;
};

/// Every feature with a geometry, of one layer (empty: of all). Errors as ReadRoads has them.
core::Expected<void> ForEachFeature(const std::string& path, const std::string& layer,
                                    const MapFrame& frame,
                                    const std::function<void(const VectorFeature&)>& visit);

/// The first of these fields that is set; empty: none.
std::string TextOf(const OGRFeature& row, const std::vector<std::string>& fields);

/// "CityGML": by the first kilobytes of the file.
bool IsCityGml(const std::string& path);

}  // namespace kawara::gis
