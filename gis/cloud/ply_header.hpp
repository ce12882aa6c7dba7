#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "gis/cloud/byte_source.hpp"

/// The head of a PLY file. Source: Greg Turk, "The PLY Polygon File Format" (1994), with the type
/// names of later writers (int8 ... float64) and their obj_info lines.
namespace kawara::gis {

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };
std::size_t SizeOf(PlyType type);
/// A number of that type, in the machine's byte order or (`swap`) the other one.
double PlyValue(PlyType type, const std::uint8_t* bytes, bool swap);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;
  std::optional<PlyType> count_type;  ///< a list: so many numbers of `type`
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
  /// Of one of them in a binary file; nullopt: it has lists.
  std::optional<std::size_t> stride() const;
};

struct PlyHeader {
  enum class Format { kAscii, kLittleEndian, kBigEndian };
  Format format = Format::kAscii;
  std::vector<PlyElement> elements;
  std::vector<std::string> comments;
  std::uint64_t lines = 0;  ///< of the header
};

/// Reads up to and with end_header. kFormat with the line that is wrong.
core::Expected<PlyHeader> ReadPlyHeader(ByteSource& source);

/// "origin: WGS 84 latitude 35.7 deg, longitude 139.7 deg, ellipsoidal height 41.25 m": what
/// gis/model/text.hpp's OriginText writes.
std::optional<core::Geodetic> OriginFromComment(std::string_view comment);

}  // namespace kawara::gis
