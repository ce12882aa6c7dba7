#pragma once
#include <string>
#include <string_view>

#include "core/geodesy.hpp"
#include "gis/kiwi/elements.hpp"
#include "gis/model/text.hpp"

/// Small pieces of text the exports share. Inside gis/kiwi only.
namespace kawara::gis {

constexpr int kDegreeDecimals = 10;  ///< 0.01 mm
constexpr int kHeightDecimals = 4;

inline std::string Longitude(const core::Geodetic& g) {
  return Number(g.lon_rad * core::kDegFromRad, kDegreeDecimals);
}
inline std::string Latitude(const core::Geodetic& g) {
  return Number(g.lat_rad * core::kDegFromRad, kDegreeDecimals);
}
inline std::string Height(const core::Geodetic& g) {
  return Number(g.h_ellipsoidal_m, kHeightDecimals);
}

/// A JSON string literal (RFC 8259).
std::string JsonString(std::string_view text);
/// "key":"value", or the bare number where the attribute has a unit.
std::string JsonMember(const Attribute& attribute);
/// The properties of an element: its attributes; several of one key become one, comma between.
std::string JsonMembers(const std::vector<Attribute>& attributes);

}  // namespace kawara::gis
