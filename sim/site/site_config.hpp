#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "sim/site/building_config.hpp"
#include "sim/site/rule_config.hpp"
#include "sim/site/thing_config.hpp"

namespace kawara::sim {

struct OriginConfig {
  double lat_deg = 35.0;
  double lon_deg = 139.0;
  double h_ellipsoidal_m = 0.0;

  template <class V>
  void Visit(V& v) {
    v("lat_deg", lat_deg, config::Range{-89.0, 89.0});
    v("lon_deg", lon_deg, config::Range{-180.0, 180.0});
    v("h_ellipsoidal_m", h_ellipsoidal_m, config::Range{-500.0, 9000.0});
  }
  core::Geodetic Geodetic() const;
};

struct SunConfig {
  double azimuth_deg = 150.0;
  double elevation_deg = 45.0;
  double sky_share = 0.35;

  template <class V>
  void Visit(V& v) {
    v("azimuth_deg", azimuth_deg, config::Range{-360.0, 360.0});
    v("elevation_deg", elevation_deg, config::Range{1.0, 90.0});
    v("sky_share", sky_share, config::Range{0.0, 1.0}, config::Optional{});
  }
};

struct TerrainConfig {
  double west_m = -100.0;  ///< of the part with all detail; beyond, the land runs on plainly
  double south_m = -60.0;
  double east_m = 100.0;
  double north_m = 60.0;
  double cell_m = 1.0;
  double slope_east_percent = 0.0;
  double slope_north_percent = 0.0;
  double undulation_m = 0.1;  ///< amplitude of the long waves
  double undulation_length_m = 45.0;
  SurfaceConfig surface{.pattern = Pattern::kSoil};

  template <class V>
  void Visit(V& v) {
    v("west_m", west_m, config::Range{-1000.0, 1000.0});
    v("south_m", south_m, config::Range{-1000.0, 1000.0});
    v("east_m", east_m, config::Range{-1000.0, 1000.0});
    v("north_m", north_m, config::Range{-1000.0, 1000.0});
    v("cell_m", cell_m, config::Range{0.25, 10.0}, config::Optional{});
    v("slope_east_percent", slope_east_percent, config::Range{-20.0, 20.0}, config::Optional{});
    v("slope_north_percent", slope_north_percent, config::Range{-20.0, 20.0}, config::Optional{});
    v("undulation_m", undulation_m, config::Range{0.0, 5.0}, config::Optional{});
    v("undulation_length_m", undulation_length_m, config::Range{10.0, 500.0}, config::Optional{});
    v("surface", surface, config::Optional{});
    v.Require(east_m - west_m >= 20.0, "east_m", "at least 20 m east of west_m");
    v.Require(north_m - south_m >= 20.0, "north_m", "at least 20 m north of south_m");
    v.Require((east_m - west_m) * (north_m - south_m) <= 400000.0 * cell_m * cell_m, "cell_m",
              "larger: at most 400000 cells");
  }
};

inline constexpr double kRoadVerge_m = 1.0;  ///< from the pavement's back to the untouched land

/// One road along a polyline whose corners are rounded. It runs straight on past its ends.
struct RoadConfig {
  std::vector<EastNorth> points_m;
  double width_m = 7.0;  ///< between the kerbs
  double corner_radius_m = 15.0;
  double crown_percent = 2.0;   ///< cross fall from the middle to the kerbs
  double roughness_m = 0.003;   ///< height noise from metre to metre, peak
  double kerb_height_m = 0.15;  ///< 0: no kerbs
  double kerb_width_m = 0.18;
  double pavement_m = 2.0;  ///< width on each side; 0: none
  bool edge_lines = true;
  bool centre_line = true;
  SurfaceConfig surface{.pattern = Pattern::kAsphalt};
  SurfaceConfig pavement{.pattern = Pattern::kTiles};

  template <class V>
  void Visit(V& v) {
    v("points_m", points_m, config::Range{-1000.0, 1000.0}, config::NotEmpty{});
    v("width_m", width_m, config::Range{2.0, 40.0});
    v("corner_radius_m", corner_radius_m, config::Range{1.0, 500.0}, config::Optional{});
    v("crown_percent", crown_percent, config::Range{0.0, 10.0}, config::Optional{});
    v("roughness_m", roughness_m, config::Range{0.0, 0.05}, config::Optional{});
    v("kerb_height_m", kerb_height_m, config::Range{0.0, 0.5}, config::Optional{});
    v("kerb_width_m", kerb_width_m, config::Range{0.08, 1.0}, config::Optional{});
    v("pavement_m", pavement_m, config::Range{0.0, 10.0}, config::Optional{});
    v("edge_lines", edge_lines, config::Optional{});
    v("centre_line", centre_line, config::Optional{});
    v("surface", surface, config::Optional{});
    v("pavement", pavement, config::Optional{});
    v.Require(points_m.size() >= 2, "points_m", "at least 2 points");
    v.Require(CornersFit(), "corner_radius_m",
              "more than half the road with its sides, and legs long enough for the arcs");
  }

  /// From the middle to where the untouched terrain begins.
  double OuterHalfWidth() const;

 private:
  bool CornersFit() const;
};

struct WaypointConfig {
  EastNorth at_m{};
  std::optional<double> speed_mps;  ///< from here on; left out: the path's

  template <class V>
  void Visit(V& v) {
    v("at_m", at_m, config::Range{-1000.0, 1000.0});
    v("speed_mps", speed_mps, config::Range{0.05, 20.0});
  }
};

/// The way the vehicle drives.
struct RouteConfig {
  double speed_mps = 1.0;
  std::vector<WaypointConfig> points;

  template <class V>
  void Visit(V& v) {
    v("speed_mps", speed_mps, config::Range{0.05, 20.0});
    v("points", points, config::NotEmpty{});
    v.Require(points.size() >= 2, "points", "at least 2 points");
  }
};

/// A site file. `seed` decides everything that is left to chance.
struct SiteConfig {
  std::string name;
  std::uint64_t seed = 1;
  OriginConfig origin;
  SunConfig sun;
  TerrainConfig terrain;
  RoadConfig road;
  RouteConfig path;
  std::vector<BuildingConfig> buildings;
  std::vector<FenceConfig> fences;
  std::vector<RubbleConfig> rubble;
  std::vector<PropConfig> things;
  std::vector<RowConfig> rows;
  std::vector<ScatterConfig> scatter;

  template <class V>
  void Visit(V& v) {
    v("name", name, config::NotEmpty{});
    v("seed", seed);
    v("origin", origin);
    v("sun", sun);
    v("terrain", terrain);
    v("road", road);
    v("path", path);
    v("buildings", buildings, config::Optional{});
    v("fences", fences, config::Optional{});
    v("rubble", rubble, config::Optional{});
    v("things", things, config::Optional{});
    v("rows", rows, config::Optional{});
    v("scatter", scatter, config::Optional{});
    v.Require(PathInside(), "path", "every point inside the terrain's detailed part");
    v.Require(RepeatedName().empty(), "name", "every name of a thing once only");
  }

  /// The first name that two things have; empty: none.
  std::string RepeatedName() const;

 private:
  bool PathInside() const;
};

/// Reads a site file; the error names every mistake in it, "file:line:column: key = value:
/// expected ...". `overrides`: "dotted.key=value", as --set on a command line.
core::Expected<SiteConfig> LoadSite(const std::string& path,
                                    const std::vector<std::string>& overrides = {});

}  // namespace kawara::sim
