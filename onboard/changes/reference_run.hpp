#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "core/time.hpp"
#include "vision/change/reference_map.hpp"

namespace kawara::changes {

/// What a reference is made from; all may be given, at least one must.
struct ReferenceOptions {
  std::optional<core::Geodetic> origin;  ///< of the map; else of the first file that says one
  bool local = false;                    ///< all files are in metres of the map, whatever they say
  std::vector<std::filesystem::path> clouds;  ///< of laser scanners, or an earlier drive's model
  double cloud_sd_m = 0.02;
  std::vector<std::filesystem::path> buildings;
  double building_sd_m = 0.0;  ///< 0: as the file says, else by its level of detail
  std::string height_field;
  std::filesystem::path ground;  ///< raster of heights
  double ground_sd_m = 0.10;
  double geoid_separation_m = 0.0;
  std::vector<std::filesystem::path> roads;
  std::string road_name;  ///< only shapes of this name; empty: all
  core::UtcTime date;     ///< of everything; not set: as the files say, or nobody knows
  std::function<void(const std::string&)> say;  ///< lines that people should read
};

struct ReferenceResult {
  vision::ReferenceMap map;
  std::uint64_t cloud_points = 0;
  std::size_t buildings = 0;
};

/// Roads and ground raster into a reference that is there already (kawara-changes takes them
/// directly too); `roads`, `road_name`, `ground` and how they are read of `options`.
core::Expected<void> AddRoads(const ReferenceOptions& options, vision::ReferenceMap& reference);
core::Expected<void> AddGround(const ReferenceOptions& options, vision::ReferenceMap& reference);

/// The paper's "before" model and what GIS hold of it. Errors: those of the files.
core::Expected<ReferenceResult> BuildReference(const ReferenceOptions& options);

/// What a reference holds, for people, one line a thing.
std::string Describe(const vision::ReferenceMap& reference);

}  // namespace kawara::changes
