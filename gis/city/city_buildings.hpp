#pragma once
#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "core/time.hpp"
#include "gis/city/triangulate.hpp"
#include "gis/frame/map_frame.hpp"

namespace kawara::gis {

/// A building as a GIS knows it: walls and roof, without its floor.
struct CityBuilding {
  std::string name;
  int lod = 0;                        ///< 0: a footprint raised to its height
  std::vector<Triangle> triangles_m;  ///< east, north, up [m]
  double low_m = 0.0, high_m = 0.0;   ///< up
  double sigma_m = 0.0;               ///< of a surface, one standard deviation
  std::optional<core::UtcTime> date;  ///< when it was so, if the file says
};

struct CityModel {
  std::vector<CityBuilding> buildings;
  HeightDatum heights = HeightDatum::kUnknown;
  std::size_t passed_over = 0;  ///< objects without a usable shape or height
};

/// A field that tells how high a footprint is.
struct HeightField {
  std::string name;
  double metres = 1.0;  ///< a unit of it
};

struct BuildingOptions {
  std::string layer{};  ///< of a GeoPackage with several; empty: all
  /// The first that is set and positive counts. rel_height_m is what our own KIWI+ tables have.
  std::vector<HeightField> height_fields{{"height", 1.0},          {"measuredHeight", 1.0},
                                         {"measured_height", 1.0}, {"rel_height_m", 1.0},
                                         {"building:levels", 3.0}, {"building_levels", 3.0},
                                         {"levels", 3.0},          {"storeys", 3.0}};
  std::vector<std::string> name_fields{"name", "Name", "gml_id", "id"};
  std::vector<std::string> date_fields{"surveyYear", "survey_date", "date", "creationDate"};
  /// Ground under a footprint that has no heights, by east and north; not set or nullopt: 0 up.
  std::function<std::optional<double>(double, double)> ground{};
  /// What a surface is trusted to where the file (attribute sigma_m) does not say. Assumptions, not
  /// published figures: state better ones if the supplier does.
  double sigma_footprint_m = 2.0;
  double sigma_lod1_m = 1.0;
  double sigma_lod2_m = 0.5;
};

/// Reads CityGML (PLATEAU), CityJSON, or footprints with heights from any vector file GDAL knows.
/// A 3D polygon that is not level is a wall or roof itself. Errors as ReadRoads; kNotFound for a
/// file without any building.
core::Expected<CityModel> ReadBuildings(const std::string& path, const MapFrame& frame,
                                        const BuildingOptions& options = {});

}  // namespace kawara::gis
