#include "gis/city/road_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gis/city/ring.hpp"
#include "gis/polygon_file.hpp"
#include "sim/site/reference_model.hpp"
#include "tests/support/test_folder.hpp"
#include "tests/unit/gis_city/city_files.hpp"

namespace kawara::gis {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using testing::TestFolder;

const core::Geodetic kOrigin{35.7 * core::kRadFromDeg, 139.7 * core::kRadFromDeg, 41.25};

std::string GeoJson(const std::string& geometry) {
  return R"({"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {"name": )"
         R"("Factory Road"}, "geometry": )" +
         geometry + "}]}";
}

TEST(RoadMap, PolygonWithAHoleInDegrees) {
  const TestFolder folder;
  const auto at = [](double e, double n) {
    return "[" + Position(kOrigin, {e, n, 2.5}, false, ", ") + "]";
  };
  // Clockwise, and the hole the other way: the file's order is not trusted.
  const std::string path =
      WriteTo(folder / "road.geojson",
              GeoJson(R"({"type": "Polygon", "coordinates": [[)" + at(0, 0) + "," + at(0, 8) + "," +
                      at(40, 8) + "," + at(40, 0) + "," + at(0, 0) + "],[" + at(10, 2) + "," +
                      at(12, 2) + "," + at(12, 4) + "," + at(10, 4) + "," + at(10, 2) + "]]}"));
  const auto map = ReadRoads(path, {kOrigin});
  ASSERT_TRUE(map) << map.error().message;
  ASSERT_THAT(map->polygons, SizeIs(1));
  const RoadPolygon& road = map->polygons[0];
  EXPECT_EQ(road.name, "Factory Road");
  EXPECT_TRUE(road.has_heights);
  EXPECT_THAT(road.outer_m, SizeIs(4));
  EXPECT_NEAR(PlanArea(road.outer_m), 320.0, 0.01);
  ASSERT_THAT(road.holes_m, SizeIs(1));
  EXPECT_NEAR(PlanArea(road.holes_m[0]), -4.0, 0.001);
  for (const Vector3d& p : road.outer_m) EXPECT_NEAR(p.z(), 2.5, 0.001);
}

TEST(RoadMap, LocalMetresMustBeSaid) {
  const TestFolder folder;
  const std::string path =
      WriteTo(folder / "road.geojson",
              GeoJson(R"({"type": "MultiPolygon", "coordinates": [[[[-1000, -4], [1000, -4], )"
                      R"([1000, 4], [-1000, 4], [-1000, -4]]]]})"));
  const auto refused = ReadRoads(path, {kOrigin});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, core::ErrorCode::kInvalidArgument);
  EXPECT_THAT(refused.error().message, HasSubstr("local metres"));
  const auto map = ReadRoads(path, {kOrigin, Coordinates::kLocalMetres});
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_EQ(map->polygons.at(0).outer_m.at(0), Vector3d(-1000, -4, 0));
  EXPECT_FALSE(map->polygons.at(0).has_heights);
}

TEST(RoadMap, CentreLinesAreLines) {
  const TestFolder folder;
  const std::string path =
      WriteTo(folder / "line.geojson",
              GeoJson(R"({"type": "LineString", "coordinates": [[0, 0], [500, 20], [1000, 0]]})"));
  const auto map = ReadRoads(path, {kOrigin, Coordinates::kLocalMetres});
  ASSERT_TRUE(map) << map.error().message;
  ASSERT_THAT(map->lines, SizeIs(1));
  EXPECT_EQ(map->lines[0].points_m[1], Vector3d(500, 20, 0));
}

TEST(RoadMap, GeoPackageAndItsLayers) {
  const TestFolder folder;
  PolygonFeature feature;
  feature.faces_lon_lat_h.emplace_back();
  for (const auto& [e, n] : {std::pair{0.0, 0.0}, {20.0, 0.0}, {20.0, 5.0}, {0.0, 5.0}}) {
    const core::Geodetic g = core::LocalEnu(kOrigin).ToGeodetic({e, n, 0});
    feature.faces_lon_lat_h[0].emplace_back(g.lon_rad * core::kDegFromRad,
                                            g.lat_rad * core::kDegFromRad, g.h_ellipsoidal_m);
  }
  feature.values = {std::string("a")};
  PolygonLayer roads{"roads", "roads", {{"name", FieldType::kText, false}}, {feature}};
  PolygonLayer other = roads;
  other.name = "other";
  const std::string path = (folder / "r.gpkg").string();
  ASSERT_TRUE(WritePolygonFile(path, std::array{roads, other}));
  const auto one = ReadRoads(path, {kOrigin}, {.layer = "roads"});
  ASSERT_TRUE(one) << one.error().message;
  ASSERT_THAT(one->polygons, SizeIs(1));
  EXPECT_NEAR(PlanArea(one->polygons[0].outer_m), 100.0, 0.001);
  EXPECT_THAT(ReadRoads(path, {kOrigin})->polygons, SizeIs(2));
  const auto none = ReadRoads(path, {kOrigin}, {.layer = "rivers"});
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message, HasSubstr("no layer rivers (it has: roads, other)"));
}

std::string TranRoad(const std::string& reference, bool latitude_first) {
  std::string positions;
  for (const Vector3d& p : {Vector3d(0, 0, 0), Vector3d(30, 0, 0), Vector3d(30, 6, 0),
                            Vector3d(0, 6, 0), Vector3d(0, 0, 0)})
    positions += Position(kOrigin, p, latitude_first, " ") + " ";
  return R"(<?xml version="1.0" encoding="UTF-8"?>
<core:CityModel xmlns:core="http://www.opengis.net/citygml/2.0" xmlns:gml="http://www.opengis.net/gml"
 xmlns:tran="http://www.opengis.net/citygml/transportation/2.0">
<gml:boundedBy><gml:Envelope srsName=")" +
         reference + R"(" srsDimension="3"><gml:lowerCorner>0 0 0</gml:lowerCorner></gml:Envelope>
</gml:boundedBy><core:cityObjectMember><tran:Road gml:id="road_1"><gml:name>Route 1</gml:name>
<tran:lod1MultiSurface><gml:MultiSurface><gml:surfaceMember><gml:Polygon><gml:exterior><gml:LinearRing>
<gml:posList>)" +
         positions +
         R"(</gml:posList></gml:LinearRing></gml:exterior></gml:Polygon></gml:surfaceMember>
</gml:MultiSurface></tran:lod1MultiSurface></tran:Road></core:cityObjectMember></core:CityModel>)";
}

TEST(RoadMap, CityGmlInEitherOrderOfAxes) {
  const TestFolder folder;
  // The last two say one thing and do another.
  for (const auto& [reference, latitude_first] :
       {std::pair{"http://www.opengis.net/def/crs/EPSG/0/6697", true},
        {"EPSG:6697", false},
        {"http://www.opengis.net/def/crs/EPSG/0/6697", false},
        {"EPSG:6697", true}}) {
    const auto map =
        ReadRoads(WriteTo(folder / "r.gml", TranRoad(reference, latitude_first)), {kOrigin});
    ASSERT_TRUE(map) << map.error().message;
    ASSERT_THAT(map->polygons, SizeIs(1));
    EXPECT_EQ(map->polygons[0].name, "Route 1");
    EXPECT_EQ(map->heights, HeightDatum::kSeaLevel);
    EXPECT_NEAR(PlanArea(map->polygons[0].outer_m), 180.0, 0.01);
    EXPECT_LT(map->polygons[0].outer_m[0].norm(), 0.001);
  }
}

TEST(RoadMap, DamagedAndMissingFilesAreSaid) {
  const TestFolder folder;
  std::string cut = TranRoad("EPSG:6697", false);
  cut.resize(cut.size() - 100);
  const std::pair<std::string, core::ErrorCode> cases[] = {
      {(folder / "none.geojson").string(), core::ErrorCode::kNotFound},
      {WriteTo(folder / "text.txt", "hello"), core::ErrorCode::kFormat},
      {WriteTo(folder / "cut.geojson", R"({"type": "FeatureCollection", "features": [{"ty)"),
       core::ErrorCode::kFormat},
      {WriteTo(folder / "cut.gml", cut), core::ErrorCode::kFormat},
      {WriteTo(folder / "point.geojson", GeoJson(R"({"type": "Point", "coordinates": [139, 35]})")),
       core::ErrorCode::kNotFound},
  };
  for (const auto& [path, code] : cases) {
    const auto map = ReadRoads(path, {kOrigin});
    ASSERT_FALSE(map) << path;
    EXPECT_EQ(map.error().code, code) << map.error().message;
    EXPECT_THAT(map.error().message, HasSubstr(path));
  }
}

TEST(RoadMap, OfASimulatedSite) {
  const TestFolder folder;
  const auto loaded =
      sim::LoadSite(std::string(KAWARA_SOURCE_DIR) + "/configs/sites/factory_road.yaml");
  ASSERT_TRUE(loaded) << loaded.error().message;
  const sim::SiteConfig& site = *loaded;
  const sim::Terrain terrain(site);
  const std::string path = (folder / "road.geojson").string();
  ASSERT_TRUE(sim::WriteRoadGeoJson(site, terrain, path));
  const auto map = ReadRoads(path, {site.origin.Geodetic()});
  ASSERT_TRUE(map) << map.error().message;
  ASSERT_THAT(map->polygons, SizeIs(2));
  const auto want = sim::RoadPolygon(site, terrain, false);
  EXPECT_EQ(map->polygons[0].name, "carriageway");
  EXPECT_NEAR(PlanArea(map->polygons[0].outer_m), PlanArea(want), 0.05);
}

}  // namespace
}  // namespace kawara::gis
