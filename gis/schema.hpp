#pragma once
#include <span>
#include <string>

#include "core/time.hpp"

/// The layers of the spatial temporal store: one table drives their making, their filling and their
/// dump. The feature-space idea (every element has a class code, a place, an existence from t_begin
/// to t_end, and a change closes a row instead of overwriting it) is that of DiMSIS and KIWI+;
/// names, codes and columns are this project's own. Sources: Hatayama, Kakumoto, Kameda, ISPRS Vol.
/// 34 Part 2W2 (2001) pp. 123-125; JP4093296B2.
namespace kawara::gis {

enum class FieldType { kText, kInteger, kReal, kTime, kFlag };

struct Field {
  const char* name;
  FieldType type;
  bool required;  ///< NOT NULL
  /// Came with a later version: a store without it is given it, NULL in the rows it has.
  bool later = false;
};

enum class GeometryKind {
  kNone,
  kPoint,
  kPointZ,
  kLineString,
  kLineStringZ,
  kLineStringZm,
  kPolygonZ,
  kMultiPolygonZ
};

struct LayerSchema {
  const char* name;
  const char* title;
  GeometryKind geometry;
  std::span<const Field> fields;
  const char* key;        ///< unique: "robot, mission, epoch"
  const char* order_key;  ///< the integer column of the key that orders rows
  const char* index;      ///< further index ("robot, gps_ns"), empty: none
  const char* fid = "fid";
};

inline constexpr const char* kObsPose = "obs_pose";
inline constexpr const char* kObsPanorama = "obs_panorama";
inline constexpr const char* kTrajectory = "trajectory";
inline constexpr const char* kEventLog = "event_log";

/// obs_pose, obs_panorama, trajectory, event_log. Geometry is EPSG:4326, longitude first, Z the
/// ellipsoidal height in metres (also as columns), M of a trajectory POSIX seconds UTC.
std::span<const LayerSchema> Schema();
const LayerSchema& LayerByName(const std::string& name);

/// "2026-11-22T06:25:24.123Z": UTC, milliseconds rounded DOWN, so that begin <= T < end stays true
/// of the text.
std::string IsoUtc(core::UtcTime t);

/// SQL string literal, quotes doubled. For text that CheckText (record_check.hpp) accepts.
std::string SqlText(const std::string& text);

}  // namespace kawara::gis
