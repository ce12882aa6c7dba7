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
#include "vision/change/align_reference.hpp"
#include "vision/change/change_finder.hpp"
#include "vision/change/object_tracker.hpp"

namespace kawara::changes {

struct ChangeRunOptions {
  std::vector<std::filesystem::path> inputs;  ///< clouds (PLY, LAS), or one folder of kawara-mapper
  std::filesystem::path reference;            ///< of kawara-reference; empty: none
  std::vector<std::filesystem::path> roads;   ///< beside those of the reference
  std::string road_name;                      ///< only shapes of this name; empty: all
  std::filesystem::path ground;               ///< raster; else the reference's, else estimated
  double geoid_separation_m = 0.0;
  std::string out;                       ///< GeoPackage or "PG:..."
  std::optional<core::Geodetic> origin;  ///< of the map; else of the inputs, or the reference
  bool local = false;                    ///< all files are in metres of the map, whatever they say
  std::optional<Eigen::Vector3d> sensor_m;  ///< where a cloud of one standpoint was taken from
  double cloud_sd_m = 0.03;
  double voxel_m = 0.20;  ///< of clouds
  std::string survey = "survey", robot;
  core::UtcTime time;  ///< of the look
  vision::FinderOptions finder;
  bool align = true;
  std::function<void(const std::string&)> say;  ///< lines that people should read
};

struct ChangeRunResult {
  std::uint64_t points = 0;  ///< read of clouds
  vision::Alignment alignment;
  std::vector<core::ChangedObject> revisions;  ///< that this run told the register
  std::vector<core::ChangedObject> objects;    ///< that stand now
  std::vector<core::RoadStation> stations;
  double narrowest_m = 0.0;  ///< of the stations that were looked at
  std::size_t stations_seen = 0;
  double seconds = 0.0;
  core::Geodetic origin;
};

/// The 3rd update of a model or of anybody's points: against a reference, into a register of KIWI+
/// objects. A register that is there already is gone on with: its objects keep their uids, and
/// those whose ground is now seen bare are closed. Errors: those of the files; kInvalidArgument: no
/// road, no origin, a reference that does not fit.
core::Expected<ChangeRunResult> RunChanges(const ChangeRunOptions& options);

}  // namespace kawara::changes
