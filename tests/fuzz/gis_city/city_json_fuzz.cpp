#include <cstdint>
#include <cstdlib>
#include <string>

#include "gis/city/city_json.hpp"
#include "gis/city/triangulate.hpp"

/// Any bytes as a CityJSON file in local metres: surfaces of finite corners, which fall into finite
/// triangles, or a line that says why not.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kawara::gis;
  const std::string text(reinterpret_cast<const char*>(data), size);
  const MapFrame local{{}, Coordinates::kLocalMetres};
  const auto read = ParseCityJson(text, "fuzz.json", local);
  if (!read) {
    if (read.error().message.empty()) std::abort();
    return 0;
  }
  for (const CityObject& object : read->objects)
    for (const CitySurface& surface : object.surfaces)
      for (const Triangle& triangle : Triangulate(surface))
        for (const auto& corner : triangle)
          if (!corner.allFinite()) std::abort();
  return 0;
}
