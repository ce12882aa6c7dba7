#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/time.hpp"

/// The elements of a KIWI+ data set as this project's open profile has them (docs/kiwi_plus.md says
/// which notions are published and which are ours). Longitude and latitude in WGS 84 degrees,
/// heights in metres above the ellipsoid, times UTC. An element exists from its beginning until it
/// is closed, over begin <= T < end. Sources: Hatayama, Kakumoto, Kameda, ISPRS Vol. 34 Part 2W2
/// (2001) pp. 123-125 (vectors, connectors, feature spaces); JP4093296B2 (attributes on a connector
/// at the representative point, a new connector for a new attribute); the DiMSIS project's page on
/// its data format (flags, one height pair and one time an element).
namespace kawara::gis {

struct LonLat {
  double lon_deg = 0.0;
  double lat_deg = 0.0;
  bool operator==(const LonLat&) const = default;
};

/// An element's one height: its foot above the ellipsoid, and how far it stands up from there.
struct HeightPair {
  double base_elev_m = 0.0;
  double rel_height_m = 0.0;
  bool operator==(const HeightPair&) const = default;
};

/// Bits of `flags`.
constexpr std::uint32_t kMultiLink = 1U;  ///< only the line's ends are nodes, not its vertices
/// The height pair or the outline says less than kp_box does: the box is not level to a millimetre.
constexpr std::uint32_t kLossy = 2U;

/// What kinds of things there are.
struct FeatureSpace {
  std::string class_code;
  std::string name;
  std::string dim;     ///< "point", "line", "area", "volume", "trajectory"
  std::string parent;  ///< class code, empty: none
};

inline constexpr const char* kClassBox = "change.box";
inline constexpr const char* kClassBoxOutline = "change.box.outline";
inline constexpr const char* kClassRoadWidth = "status.road_width";
inline constexpr const char* kClassRoadBlocked = "status.road_blocked";
inline constexpr const char* kClassModel = "model.vrml";

/// All of the profile's, parents first.
std::span<const FeatureSpace> FeatureSpaces();

struct VectorElement {
  std::string id;
  std::string class_code;
  std::uint32_t flags = 0;
  std::vector<LonLat> line;  ///< 2 or more; an outline ends where it begins
  HeightPair height;
  core::UtcTime begin;
};

struct ConnectorElement {
  std::string id;
  std::string class_code;
  std::uint32_t flags = 0;
  LonLat place;  ///< the representative point: inside the outline it speaks for
  HeightPair height;
  core::UtcTime begin;
  std::string object_uid;  ///< what it speaks for, the same through all its revisions
};

struct Attribute {
  std::string connector_id;
  std::string key;
  std::string value;
  std::string unit;  ///< "m", "deg", "s", "1", "px"; empty: text
};

/// One thing of the world at one time: vectors, the connector that speaks for them, and what it
/// says.
struct ElementSet {
  std::vector<VectorElement> vectors;
  ConnectorElement connector;
  std::vector<Attribute> attributes;
};

}  // namespace kawara::gis
