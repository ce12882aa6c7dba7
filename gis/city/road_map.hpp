#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "gis/frame/map_frame.hpp"

namespace kawara::gis {

/// One area of road. Rings are not closed, in the map's east, north, up [m]; up is 0 where the file
/// has no heights.
struct RoadPolygon {
  std::string name;                                   ///< empty: the file has none
  std::vector<Eigen::Vector3d> outer_m;               ///< counter-clockwise, 3 corners or more
  std::vector<std::vector<Eigen::Vector3d>> holes_m;  ///< clockwise
  bool has_heights = false;
};

/// A line along a road, as the file has it.
struct RoadLine {
  std::string name;
  std::vector<Eigen::Vector3d> points_m;  ///< 2 or more
  bool has_heights = false;
};

struct RoadMap {
  std::vector<RoadPolygon> polygons;
  std::vector<RoadLine> lines;
  HeightDatum heights = HeightDatum::kUnknown;
  std::size_t passed_over = 0;  ///< features that are neither, or degenerate, or out of the world
};

struct RoadOptions {
  std::string layer{};  ///< of a GeoPackage with several; empty: all layers
  std::vector<std::string> name_fields{"name", "Name", "NAME", "gml_id", "id"};
};

/// Reads GeoJSON, GeoPackage, Shapefile or any other vector file GDAL knows, or the road areas
/// (tran:Road) of a CityGML file (PLATEAU).
///
/// kFromFile: in the reference system the file states; GeoJSON states none and is longitude and
/// latitude (RFC 7946), unless its numbers cannot be such: then it must be said that they are local
/// metres. Errors, with the way to mend them: kNotFound; kFormat; kInvalidArgument: no reference
/// system, no such layer; kNotFound also for a file without any road.
core::Expected<RoadMap> ReadRoads(const std::string& path, const MapFrame& frame,
                                  const RoadOptions& options = {});

}  // namespace kawara::gis
