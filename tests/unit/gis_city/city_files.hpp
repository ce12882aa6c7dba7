#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/geodesy.hpp"

namespace kawara::gis {

inline std::string WriteTo(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
  return path.string();
}

/// "longitude latitude height" (or latitude first) of a point of the map, with this between them.
inline std::string Position(const core::Geodetic& origin, const Eigen::Vector3d& enu_m,
                            bool latitude_first, const std::string& between) {
  const core::Geodetic g = core::LocalEnu(origin).ToGeodetic(enu_m);
  std::array<char, 100> text{};
  const double lat = g.lat_rad * core::kDegFromRad, lon = g.lon_rad * core::kDegFromRad;
  std::snprintf(text.data(), text.size(), "%.11f%s%.11f%s%.5f", latitude_first ? lat : lon,
                between.c_str(), latitude_first ? lon : lat, between.c_str(), g.h_ellipsoidal_m);
  return text.data();
}

}  // namespace kawara::gis
