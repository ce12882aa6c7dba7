#include "onboard/changes/reference_run.hpp"

#include <algorithm>
#include <array>
#include <cinttypes>
#include <cmath>
#include <cstdio>

#include "core/iso8601.hpp"
#include "gis/city/city_buildings.hpp"
#include "gis/city/ground_raster.hpp"
#include "gis/city/road_map.hpp"
#include "gis/cloud/cloud.hpp"
#include "vision/change/reference_builder.hpp"
#include "vision/change/road_area.hpp"

namespace kawara::changes {
namespace {

constexpr double kGroundCell = 0.5;  // m
constexpr double kBesideRoad = 3.9;  // m: less than RoadArea knows
constexpr double kFarAway = 100e3;   // m: no road that a robot drives to

gis::MapFrame FrameOf(const ReferenceOptions& options, const vision::ReferenceMap& reference,
                      bool local) {
  gis::MapFrame frame;
  frame.origin = reference.origin.value_or(core::Geodetic{});
  const bool nowhere = !reference.origin;
  frame.coordinates = local || options.local || nowhere ? gis::Coordinates::kLocalMetres
                                                        : gis::Coordinates::kFromFile;
  frame.geoid_separation_m = options.geoid_separation_m;
  return frame;
}

void WarnOfHeights(const ReferenceOptions& options, const std::filesystem::path& file,
                   gis::HeightDatum heights) {
  const std::string warning =
      gis::WarnOfHeights(file.string(), heights, options.geoid_separation_m);
  if (options.say && !warning.empty()) options.say(warning);
}

/// Files that do not say where they lie are in metres of the map: reads so, then the other way.
template <class Read>
auto ReadEither(const ReferenceOptions& options, const vision::ReferenceMap& reference,
                const std::filesystem::path& file, const Read& read) {
  auto done = read(FrameOf(options, reference, false));
  if (done || done.error().code != core::ErrorCode::kInvalidArgument) return done;
  auto local = read(FrameOf(options, reference, true));
  if (!local) return done;  // the first complaint is the one to mend
  if (options.say)
    options.say(file.string() + ": does not say where it lies: taken as metres of the map");
  return local;
}

bool FarAway(const gis::RoadMap& roads) {
  for (const auto& polygon : roads.polygons)
    for (const Eigen::Vector3d& p : polygon.outer_m)
      if (p.head<2>().norm() < kFarAway) return false;
  return !roads.polygons.empty();
}

core::Expected<gis::RoadMap> ReadRoadFile(const ReferenceOptions& options,
                                          const vision::ReferenceMap& reference,
                                          const std::filesystem::path& file) {
  auto roads = ReadEither(options, reference, file, [&](const gis::MapFrame& frame) {
    return gis::ReadRoads(file.string(), frame);
  });
  // Metres of a map written as GeoJSON look like degrees of far away places.
  if (!roads || !FarAway(*roads)) return roads;
  auto local = gis::ReadRoads(file.string(), FrameOf(options, reference, true));
  if (!local || FarAway(*local)) return roads;
  if (options.say) options.say(file.string() + ": lies here as metres of the map, and is taken so");
  return local;
}

/// Of the first place in the roads and buildings that say where they lie, at the ellipsoid's
/// height.
std::optional<core::Geodetic> OriginOfFiles(const ReferenceOptions& options) {
  gis::MapFrame anywhere;
  anywhere.coordinates = gis::Coordinates::kFromFile;
  const auto place = [](const Eigen::Vector3d& p) {
    core::Geodetic there = core::LocalEnu(core::Geodetic{}).ToGeodetic(p);
    there.h_ellipsoidal_m = 0.0;
    return there;
  };
  for (const auto& file : options.roads) {
    const auto roads = gis::ReadRoads(file.string(), anywhere);
    if (roads && !roads->polygons.empty()) return place(roads->polygons.front().outer_m.front());
  }
  for (const auto& file : options.buildings) {
    const auto city = gis::ReadBuildings(file.string(), anywhere, {});
    if (city && !city->buildings.empty() && !city->buildings.front().triangles_m.empty())
      return place(city->buildings.front().triangles_m.front()[0]);
  }
  return {};
}

std::vector<Eigen::Vector2d> Flat(const std::vector<Eigen::Vector3d>& points) {
  std::vector<Eigen::Vector2d> flat;
  flat.reserve(points.size());
  for (const Eigen::Vector3d& p : points) flat.emplace_back(p.head<2>());
  return flat;
}

core::Expected<void> AddClouds(const ReferenceOptions& options, vision::ReferenceBuilder& builder,
                               vision::ReferenceMap& place, std::uint64_t& points) {
  for (const auto& cloud : options.clouds) {
    const auto info = gis::ReadCloudInfo(cloud.string());
    if (!info) return tl::unexpected(info.error());
    if (!place.origin && !options.local)
      if (const auto origin = gis::OriginOf(*info, options.geoid_separation_m))
        place.origin = *origin;
    builder.Begin({cloud.filename().string(), "cloud", options.date, options.cloud_sd_m});
    std::vector<Eigen::Vector3d> chunk_m;
    const auto read = ReadEither(options, place, cloud, [&](const gis::MapFrame& frame) {
      return gis::ReadCloudEnu(cloud.string(), frame, [&](auto chunk) {
        chunk_m.clear();
        for (const gis::CloudPoint& p : chunk) chunk_m.push_back(p.position);
        builder.AddPoints(chunk_m);
      });
    });
    if (!read) return tl::unexpected(read.error());
    WarnOfHeights(options, cloud, read->heights);
    points += read->delivered;
  }
  return {};
}

core::Expected<void> AddBuildings(const ReferenceOptions& options,
                                  const vision::ReferenceMap& place,
                                  vision::ReferenceBuilder& builder, std::size_t& count) {
  for (const auto& file : options.buildings) {
    gis::BuildingOptions reading;
    if (!options.height_field.empty()) reading.height_fields = {{options.height_field, 1.0}};
    reading.ground = [&](double east, double north) -> std::optional<double> {
      const auto up = place.ground.At({east, north});
      return up ? std::optional(up->up_m) : std::nullopt;
    };
    const auto city = ReadEither(options, place, file, [&](const gis::MapFrame& frame) {
      return gis::ReadBuildings(file.string(), frame, reading);
    });
    if (!city) return tl::unexpected(city.error());
    WarnOfHeights(options, file, city->heights);
    for (const gis::CityBuilding& building : city->buildings) {
      const double sd = options.building_sd_m > 0.0 ? options.building_sd_m : building.sigma_m;
      const core::UtcTime date = building.date.value_or(options.date);
      builder.Begin({file.filename().string(), "city model", date, sd});
      for (const gis::Triangle& triangle : building.triangles_m)
        builder.AddFace({{triangle[0], triangle[1], triangle[2]}});
      ++count;
    }
  }
  return {};
}

}  // namespace

core::Expected<void> AddRoads(const ReferenceOptions& options, vision::ReferenceMap& reference) {
  for (const auto& file : options.roads) {
    auto roads = ReadRoadFile(options, reference, file);
    if (!roads) return tl::unexpected(roads.error());
    const auto wanted = [&](const std::string& name) {
      return options.road_name.empty() || name == options.road_name;
    };
    for (const gis::RoadPolygon& polygon : roads->polygons) {
      if (!wanted(polygon.name)) continue;
      vision::RoadPolygon road{polygon.name, Flat(polygon.outer_m), {}};
      for (const auto& hole : polygon.holes_m) road.holes.push_back(Flat(hole));
      reference.roads.push_back(std::move(road));
    }
    for (const gis::RoadLine& line : roads->lines)
      if (wanted(line.name)) reference.road_axes.emplace_back(line.name, Flat(line.points_m));
  }
  if (!options.roads.empty() && reference.roads.empty())
    return core::Fail(
        core::ErrorCode::kInvalidArgument,
        options.roads.front().string() + ": has no area of a road" +
            (options.road_name.empty() ? "" : " of the name '" + options.road_name + "'"));
  return {};
}

core::Expected<void> AddGround(const ReferenceOptions& options, vision::ReferenceMap& reference) {
  if (reference.roads.empty())
    return core::Fail(
        core::ErrorCode::kInvalidArgument,
        "a ground raster is taken about the road only: give the road as well (--road)");
  const auto road = vision::RoadArea::Make(reference.roads);
  if (!road) return tl::unexpected(road.error());
  const Eigen::Vector2d around = Eigen::Vector2d::Constant(2.0 * kBesideRoad);
  const Eigen::Vector2d low_m = road->min_m() - around, high_m = road->max_m() + around;
  gis::GroundOptions reading;
  reading.radius_m = std::max(low_m.norm(), high_m.norm()) + 50.0;
  const auto heights =
      ReadEither(options, reference, options.ground, [&](const gis::MapFrame& frame) {
        return gis::GroundRaster::Read(options.ground.string(), frame, reading);
      });
  if (!heights) return tl::unexpected(heights.error());
  WarnOfHeights(options, options.ground, heights->heights());
  reference.sources.push_back(
      {options.ground.filename().string(), "raster", options.date, options.ground_sd_m});
  reference.ground = vision::GroundField(kGroundCell);
  const auto low = reference.ground.CellOf(low_m), high = reference.ground.CellOf(high_m);
  for (std::int32_t y = low.second; y <= high.second; ++y)
    for (std::int32_t x = low.first; x <= high.first; ++x) {
      const Eigen::Vector2d at((x + 0.5) * kGroundCell, (y + 0.5) * kGroundCell);
      if (road->SignedDistance(at) < -kBesideRoad) continue;
      if (const auto up = heights->HeightAt(at.x(), at.y()))
        reference.ground.Set({x, y}, {*up, options.ground_sd_m});
    }
  if (reference.ground.empty())
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      options.ground.string() + ": has no heights where the road is");
  return {};
}

core::Expected<ReferenceResult> BuildReference(const ReferenceOptions& options) {
  ReferenceResult result;
  vision::ReferenceBuilder builder;
  vision::ReferenceMap place;  // roads and ground first: buildings without a foot stand on it
  place.origin = options.origin;
  if (auto done = AddClouds(options, builder, place, result.cloud_points); !done)
    return tl::unexpected(done.error());
  if (!place.origin && !options.local && options.clouds.empty()) {
    place.origin = OriginOfFiles(options);
    if (place.origin && options.say)
      options.say(
          "the map's origin is the first corner of the files; metres of a map need --local");
  }
  if (auto done = AddRoads(options, place); !done) return tl::unexpected(done.error());
  if (!options.ground.empty())
    if (auto done = AddGround(options, place); !done) return tl::unexpected(done.error());
  if (auto done = AddBuildings(options, place, builder, result.buildings); !done)
    return tl::unexpected(done.error());
  result.map = builder.Finish(options.ground.empty() && !options.clouds.empty());
  result.map.origin = place.origin;
  result.map.roads = std::move(place.roads);
  result.map.road_axes = std::move(place.road_axes);
  for (const auto& source : place.sources) result.map.sources.push_back(source);
  if (!place.ground.empty()) result.map.ground = std::move(place.ground);
  return result;
}

std::string Describe(const vision::ReferenceMap& reference) {
  std::string text;
  std::array<char, 256> line{};
  const auto add = [&](int length) {
    text.append(line.data(), static_cast<std::size_t>(std::max(0, length)));
  };
  if (reference.origin)
    add(std::snprintf(line.data(), line.size(), "origin   %.8f deg, %.8f deg, %.3f m\n",
                      reference.origin->lat_rad * core::kDegFromRad,
                      reference.origin->lon_rad * core::kDegFromRad,
                      reference.origin->h_ellipsoidal_m));
  else
    text += "origin   local metres\n";
  constexpr std::size_t kMostSources = 12;
  for (std::size_t i = 0; i < reference.sources.size(); ++i) {
    if (i == kMostSources) {
      text += "source   and " + std::to_string(reference.sources.size() - i) + " more\n";
      break;
    }
    const auto& source = reference.sources[i];
    text += "source   " + source.name + " (" + source.kind + "), ";
    text += source.date.IsSet() ? core::FormatIso8601(source.date) : "of no known date";
    add(std::snprintf(line.data(), line.size(), ", good to %.2f m (1 sigma)\n", source.sd_m));
  }
  add(std::snprintf(line.data(), line.size(), "surface  %zu voxels of 0.5 m\n",
                    reference.patches()));
  add(std::snprintf(line.data(), line.size(), "ground   %zu cells of %.2f m\n",
                    reference.ground.Cells().size(), reference.ground.cell_m()));
  add(std::snprintf(line.data(), line.size(), "road     %zu polygons, %zu middle lines\n",
                    reference.roads.size(), reference.road_axes.size()));
  return text;
}

}  // namespace kawara::changes
