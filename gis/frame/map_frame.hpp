#pragma once
#include <string>

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

/// For people; empty: nothing is wrong. Heights above sea level that nothing lifts lie tens of
/// metres off those of a GNSS receiver.
inline std::string WarnOfHeights(const std::string& file, HeightDatum heights,
                                 double geoid_separation_m) {
  if (heights != HeightDatum::kSeaLevel || geoid_separation_m != 0.0) return {};
  return file +
         ": its heights are above sea level and are taken as if above the ellipsoid; give "
         "--geoid-separation METRES (35 to 40 in most of Japan)";
}

}  // namespace kawara::gis
