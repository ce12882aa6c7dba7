#pragma once
#include <string>

#include "core/expected.hpp"
#include "gis/city/city_surfaces.hpp"

namespace kawara::gis {

/// Buildings and their parts of a CityJSON file, 1.0 to 2.0: of every object the geometry with the
/// highest level of detail below 4. Templates (GeometryInstance) are passed over. The whole file is
/// in memory while it is read. Errors: kNotFound; kFormat with the object that is wrong;
/// kInvalidArgument as CityAxes has it. Source: CityJSON specifications 1.0.3, 1.1.3, 2.0.1.
core::Expected<CityObjects> ReadCityJson(const std::string& path, const MapFrame& frame);
/// The same of a text; `name` is for messages.
core::Expected<CityObjects> ParseCityJson(const std::string& text, const std::string& name,
                                          const MapFrame& frame);

/// By the first kilobytes of the file.
bool IsCityJson(const std::string& path);

}  // namespace kawara::gis
