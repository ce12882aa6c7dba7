#pragma once
#include <cstdint>
#include <string>

#include "core/expected.hpp"
#include "gis/cloud/byte_source.hpp"
#include "gis/cloud/cloud.hpp"

namespace kawara::gis {

/// The parts of a LAS file's public header that a reader of points needs. Source: ASPRS LAS
/// specifications 1.0 to 1.4 R15 (table 3: public header; section 2.5: variable length records).
struct LasHeader {
  int minor = 0;  ///< of version 1.x
  std::uint64_t points_at = 0;
  std::uint8_t format = 0;
  std::uint16_t record_bytes = 0;
  std::uint64_t points = 0;
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
  std::string crs;  ///< WKT, from the WKT record or else from the GeoTIFF keys; empty: none
};

/// Reads the header and every record before and after the points that bears on the reference
/// system. kFormat: no LAS, damaged, or compressed (LAZ).
core::Expected<LasHeader> ReadLasHeader(ByteSource& source);

/// WKT of the reference system that GeoTIFF keys describe (records 34735, 34736, 34737 as they
/// stand in the file); empty: none that GDAL understands.
std::string CrsOfGeoKeys(const std::string& keys, const std::string& doubles,
                         const std::string& text);

}  // namespace kawara::gis
