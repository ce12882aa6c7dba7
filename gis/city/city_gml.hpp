#pragma once
#include <string>

#include "core/expected.hpp"
#include "gis/city/city_surfaces.hpp"

namespace kawara::gis {

enum class CityGmlTheme {
  kBuildings,  ///< bldg:Building with its parts; the highest level of detail up to 3
  kRoads,      ///< tran:Road; the lowest level, which is the whole area
};

/// Streams a CityGML 1 or 2 file (PLATEAU's among them); memory: one object and what comes out.
/// Surfaces that others only point to (xlink:href) are taken where they stand. Errors: kNotFound;
/// kFormat with the line; kInvalidArgument as CityAxes has it. Source: OGC 12-019 (CityGML 2.0),
/// GML 3.1.1 (geometry).
core::Expected<CityObjects> ReadCityGml(const std::string& path, const MapFrame& frame,
                                        CityGmlTheme theme);

}  // namespace kawara::gis
