#pragma once
#include "core/geodesy.hpp"

namespace kawara::gis {

/// How a file's numbers are to be read.
enum class Coordinates {
  kFromFile,     ///< in the reference system the file states; an error if it states none
  kLocalMetres,  ///< already east, north, up [m] of the map, whatever the file says
};

/// What a file's heights are counted from.
enum class HeightDatum {
  kUnknown,      ///< the file does not say
  kEllipsoidal,  ///< the ellipsoid, as a GNSS receiver's
  kSeaLevel,     ///< a height system: sea level, a geoid
};
inline const char* ToString(HeightDatum datum) {
  switch (datum) {
    case HeightDatum::kEllipsoidal:
      return "above the ellipsoid";
    case HeightDatum::kSeaLevel:
      return "above sea level";
    case HeightDatum::kUnknown:
      break;
  }
  return "above an unknown zero";
}

/// The map a file is read into: local east, north, up [m] at `origin`.
struct MapFrame {
  core::Geodetic origin;
  Coordinates coordinates = Coordinates::kFromFile;
  /// How high the zero of the file's heights lies above the ellipsoid here (35 to 40 m in most of
  /// Japan). Added to every height, unless the file states ellipsoidal heights or local metres.
  double geoid_separation_m = 0.0;
};

}  // namespace kawara::gis
