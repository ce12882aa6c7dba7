#include "gis/city/city_buildings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "gis/city/city_json.hpp"
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
constexpr MapFrame kLocal{{}, Coordinates::kLocalMetres};

double AreaOf(const std::vector<Triangle>& triangles) {
  double area = 0.0;
  for (const Triangle& t : triangles) area += (t[1] - t[0]).cross(t[2] - t[0]).norm() / 2.0;
  return area;
}

TEST(Triangulate, SurfacesWithHolesKeepTheirArea) {
  const std::vector<Vector3d> square{{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 10, 0}};
  const std::vector<Vector3d> hole{{2, 2, 0}, {4, 2, 0}, {4, 4, 0}, {2, 4, 0}};
  const std::vector<Vector3d> other{{6, 6, 0}, {6, 8, 0}, {8, 8, 0}, {8, 6, 0}};
  const std::vector<Vector3d> arrow{{0, 0, 0}, {10, 5, 0}, {0, 10, 0}, {3, 5, 0}};
  const std::pair<CitySurface, double> cases[] = {
      {{square, {}}, 100.0},
      {{square, {hole}}, 96.0},
      {{square, {hole, other}}, 92.0},
      {{arrow, {}}, 35.0},
  };
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1.1, Vector3d(0.3, -0.8, 0.5).normalized()).toRotationMatrix();
  for (const auto& [surface, area] : cases) {
    EXPECT_NEAR(AreaOf(Triangulate(surface)), area, 1e-9);
    CitySurface turned = surface;
    for (Vector3d& p : turned.outer_m) p = turn * p + Vector3d(1e5, 2e5, 3);
    for (auto& ring : turned.holes_m)
      for (Vector3d& p : ring) p = turn * p + Vector3d(1e5, 2e5, 3);
    EXPECT_NEAR(AreaOf(Triangulate(turned)), area, 1e-6);
    for (const Triangle& t : Triangulate(turned))
      EXPECT_GT((t[1] - t[0]).cross(t[2] - t[0]).dot(turn.col(2)), 0.0) << "wound as the ring";
  }
}

TEST(Triangulate, DegenerateRingsGiveNothingAndNeverHang) {
  EXPECT_TRUE(Triangulate({{{0, 0, 0}, {1, 0, 0}}, {}}).empty());
  EXPECT_TRUE(Triangulate({{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {}}).empty());
  EXPECT_TRUE(Triangulate({{{0, 0, 0}, {1, 0, std::nan("")}, {1, 1, 0}}, {}}).empty());
  (void)Triangulate({{{0, 0, 0}, {4, 4, 0}, {4, 0, 0}, {0, 5, 0}}, {}});  // a bow
}

/// A block of 10 x 6 x 8 m as CityJSON; every detail that may be otherwise is an argument.
std::string BlockJson(const std::string& version, const std::string& metadata,
                      const std::string& lod,
                      const std::function<std::string(const Vector3d&)>& vertex,
                      const std::string& transform) {
  std::string vertices;
  for (const double up : {1.0, 9.0})
    for (const auto& [e, n] : {std::pair{0.0, 0.0}, {10.0, 0.0}, {10.0, 6.0}, {0.0, 6.0}})
      vertices += (vertices.empty() ? "[" : ",[") + vertex({e, n, up}) + "]";
  return R"({"type": "CityJSON", "version": ")" + version + R"(", "metadata": {)" + metadata +
         "}," + transform +
         R"("CityObjects": {"b1": {"type": "Building", "attributes": {"surveyYear": 2019},
"geometry": [{"type": "MultiSurface", "lod": "0", "boundaries": [[[0,1,2,3]]]},
{"type": "Solid", "lod": )" +
         lod + R"(, "boundaries": [[[[0,3,2,1]],[[4,5,6,7]],[[0,1,5,4]],[[1,2,6,5]],[[2,3,7,6]],
[[3,0,4,7]]]]}]}, "t": {"type": "SolitaryVegetationObject"}}, "vertices": [)" +
         vertices + "]}";
}

void ExpectTheBlock(const core::Expected<CityModel>& model) {
  ASSERT_TRUE(model) << model.error().message;
  ASSERT_THAT(model->buildings, SizeIs(1));
  const CityBuilding& b = model->buildings[0];
  EXPECT_NEAR(b.low_m, 1.0, 0.01);
  EXPECT_NEAR(b.high_m, 9.0, 0.01);
  EXPECT_NEAR(AreaOf(b.triangles_m), 2 * (10 + 6) * 8 + 60, 0.3);  // no floor
  Vector3d low = b.triangles_m[0][0], high = low;
  for (const Triangle& t : b.triangles_m)
    for (const Vector3d& p : t) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  EXPECT_LT((low - Vector3d(0, 0, 1)).norm(), 0.01) << low.transpose();
  EXPECT_LT((high - Vector3d(10, 6, 9)).norm(), 0.01) << high.transpose();
}

TEST(CityBuildings, CityJsonOfAnyVersionAndOrderOfAxes) {
  const TestFolder folder;
  const std::string url = R"("referenceSystem": "https://www.opengis.net/def/crs/EPSG/0/4979")";
  const std::string urn = R"("referenceSystem": "urn:ogc:def:crs:EPSG::4979")";
  for (const bool latitude_first : {true, false}) {
    const auto plain = [&](const Vector3d& p) { return Position(kOrigin, p, latitude_first, ","); };
    ExpectTheBlock(ReadBuildings(
        WriteTo(folder / "a.city.json", BlockJson("1.0", urn, "1", plain, "")), {kOrigin}));
    const double scale = 1e-8;
    const auto whole = [&](const Vector3d& p) {
      const core::Geodetic g = core::LocalEnu(kOrigin).ToGeodetic(p);
      const auto lat = std::llround((g.lat_rad * core::kDegFromRad - 35.0) / scale);
      const auto lon = std::llround((g.lon_rad * core::kDegFromRad - 139.0) / scale);
      return std::to_string(latitude_first ? lat : lon) + "," +
             std::to_string(latitude_first ? lon : lat) + "," +
             std::to_string(std::llround(g.h_ellipsoidal_m * 1000));
    };
    const std::string first = latitude_first ? "35,139" : "139,35";
    ExpectTheBlock(ReadBuildings(
        WriteTo(folder / "b.json",
                BlockJson("2.0", url, "\"2.2\"", whole,
                          R"("transform": {"scale": [1e-8, 1e-8, 0.001], "translate": [)" + first +
                              ",0]},")),
        {kOrigin}));
  }
}

TEST(CityBuildings, WhatTheFileSaysOfDateAndAccuracy) {
  const TestFolder folder;
  const auto local = [](const Vector3d& p) {
    return std::to_string(p.x()) + "," + std::to_string(p.y()) + "," + std::to_string(p.z());
  };
  const std::string path = WriteTo(folder / "a.json", BlockJson("1.1", "", "\"1.2\"", local, ""));
  const auto model = ReadBuildings(path, kLocal, {.sigma_lod1_m = 0.7});
  ExpectTheBlock(model);
  EXPECT_EQ(model->buildings[0].sigma_m, 0.7);
  EXPECT_EQ(model->buildings[0].name, "b1");
  EXPECT_EQ(model->buildings[0].date, DateOf("2019-01-01"));
  const auto refused = ReadBuildings(path, {kOrigin});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("no reference system"));
}

TEST(CityBuildings, TheSimulatorsCityJsonComesBack) {
  const TestFolder folder;
  for (const char* name : {"factory_road", "residential_collapse"}) {
    const auto site =
        sim::LoadSite(std::string(KAWARA_SOURCE_DIR) + "/configs/sites/" + name + ".yaml");
    ASSERT_TRUE(site) << site.error().message;
    const sim::Terrain terrain(*site);
    const std::string path = (folder / "city.json").string();
    ASSERT_TRUE(sim::WriteReferenceCityJson(*site, terrain, path));
    const auto model = ReadBuildings(path, {site->origin.Geodetic()});
    ASSERT_TRUE(model) << model.error().message;
    const auto want = sim::ReferenceBuildings(*site, terrain);
    ASSERT_EQ(model->buildings.size(), want.size());
    EXPECT_EQ(model->heights, HeightDatum::kEllipsoidal);
    for (const sim::ReferenceBuilding& b : want) {
      const auto found =
          std::find_if(model->buildings.begin(), model->buildings.end(),
                       [&b](const CityBuilding& each) { return each.name == b.name; });
      ASSERT_NE(found, model->buildings.end()) << b.name;
      EXPECT_EQ(found->lod, 2);
      EXPECT_NEAR(found->low_m, b.ground_m, 0.01);
      EXPECT_NEAR(found->high_m, b.top_m, 0.01);
    }
  }
}

TEST(CityBuildings, FootprintsRiseFromTheGround) {
  const TestFolder folder;
  const std::string path = WriteTo(folder / "f.geojson",
                                   R"({"type": "FeatureCollection", "features": [
{"type": "Feature", "properties": {"name": "tall", "height": 8},
 "geometry": {"type": "Polygon", "coordinates": [[[0, 0], [0, 6], [10, 6], [10, 0], [0, 0]]]}},
{"type": "Feature", "properties": {"name": "levels", "building:levels": "3"},
 "geometry": {"type": "Polygon", "coordinates": [[[20, 0], [30, 0], [30, 6], [20, 6], [20, 0]],
   [[22, 2], [24, 2], [24, 4], [22, 4], [22, 2]]]}},
{"type": "Feature", "properties": {"name": "flat"},
 "geometry": {"type": "Polygon", "coordinates": [[[40, 0], [50, 0], [50, 6], [40, 0]]]}}]})");
  const auto model = ReadBuildings(path, kLocal, {.ground = [](double, double) { return 1.0; }});
  ASSERT_TRUE(model) << model.error().message;
  ASSERT_THAT(model->buildings, SizeIs(2));
  EXPECT_EQ(model->passed_over, 1U);
  EXPECT_NEAR(AreaOf(model->buildings[0].triangles_m), 2 * (10 + 6) * 8 + 60, 1e-6);
  EXPECT_EQ(model->buildings[0].low_m, 1.0);
  EXPECT_EQ(model->buildings[0].high_m, 9.0);
  EXPECT_EQ(model->buildings[0].sigma_m, 2.0);
  EXPECT_EQ(model->buildings[1].high_m, 10.0);
  EXPECT_NEAR(AreaOf(model->buildings[1].triangles_m), 2 * 16 * 9 + 8 * 9 + 56, 1e-6);
}

std::string PlateauBuilding(const std::string& reference, bool latitude_first, bool with_lod2) {
  const auto polygon = [&](std::vector<Vector3d> ring) {
    std::string positions;
    ring.push_back(ring.front());
    for (const Vector3d& p : ring) positions += Position(kOrigin, p, latitude_first, " ") + " ";
    return "<gml:surfaceMember><gml:Polygon><gml:exterior><gml:LinearRing><gml:posList>" +
           positions +
           "</gml:posList></gml:LinearRing></gml:exterior></gml:Polygon></gml:surfaceMember>";
  };
  const auto block = [&](double top) {
    std::string all;
    const Vector3d c[4] = {{0, 0, 0}, {10, 0, 0}, {10, 6, 0}, {0, 6, 0}};
    const Vector3d foot(0, 0, 1), high(0, 0, top);
    all += polygon({c[0] + foot, c[3] + foot, c[2] + foot, c[1] + foot});
    all += polygon({c[0] + high, c[1] + high, c[2] + high, c[3] + high});
    for (int i = 0; i < 4; ++i)
      all += polygon({c[i] + foot, c[(i + 1) % 4] + foot, c[(i + 1) % 4] + high, c[i] + high});
    return all;
  };
  std::string lod2;
  if (with_lod2)
    lod2 =
        "<bldg:lod2Solid><gml:Solid><gml:exterior><gml:CompositeSurface><gml:surfaceMember "
        "xlink:href=\"#p1\"/></gml:CompositeSurface></gml:exterior></gml:Solid></bldg:lod2Solid>"
        "<bldg:boundedBy><bldg:WallSurface><bldg:lod2MultiSurface><gml:MultiSurface>" +
        block(9.0) +
        "</gml:MultiSurface></bldg:lod2MultiSurface></bldg:WallSurface></bldg:boundedBy>";
  return R"(<?xml version="1.0" encoding="UTF-8"?>
<core:CityModel xmlns:core="http://www.opengis.net/citygml/2.0" xmlns:gml="http://www.opengis.net/gml"
 xmlns:xlink="http://www.w3.org/1999/xlink" xmlns:uro="https://www.geospatial.jp/iur/uro/2.0"
 xmlns:bldg="http://www.opengis.net/citygml/building/2.0"><gml:boundedBy><gml:Envelope srsName=")" +
         reference + R"(" srsDimension="3"/></gml:boundedBy>
<core:cityObjectMember><bldg:Building gml:id="b1"><core:creationDate>2023-03-22</core:creationDate>
<bldg:lod0RoofEdge><gml:MultiSurface>)" +
         polygon({{0, 0, 0}, {20, 0, 0}, {20, 20, 0}}) +
         R"(</gml:MultiSurface></bldg:lod0RoofEdge><bldg:lod1Solid><gml:Solid><gml:exterior>
<gml:CompositeSurface>)" +
         block(with_lod2 ? 7.0 : 9.0) +
         "</gml:CompositeSurface></gml:exterior></gml:Solid></bldg:lod1Solid>" + lod2 +
         R"(<uro:bldgDataQualityAttribute><uro:surveyYear>2020</uro:surveyYear>
</uro:bldgDataQualityAttribute></bldg:Building></core:cityObjectMember></core:CityModel>)";
}

TEST(CityBuildings, PlateauInEitherOrderOfAxesAndLevel) {
  const TestFolder folder;
  for (const bool with_lod2 : {false, true})
    for (const bool latitude_first : {true, false}) {
      const auto model = ReadBuildings(
          WriteTo(folder / "b.gml", PlateauBuilding("http://www.opengis.net/def/crs/EPSG/0/6697",
                                                    latitude_first, with_lod2)),
          {kOrigin});
      ExpectTheBlock(model);
      EXPECT_EQ(model->buildings[0].lod, with_lod2 ? 2 : 1);
      EXPECT_EQ(model->buildings[0].date, DateOf("2020-01-01"));
      EXPECT_EQ(model->heights, HeightDatum::kSeaLevel);
    }
}

TEST(CityBuildings, DamagedFilesAreSaid) {
  const TestFolder folder;
  const auto local = [](const Vector3d& p) {
    return std::to_string(p.x()) + "," + std::to_string(p.y()) + "," + std::to_string(p.z());
  };
  const std::string good = BlockJson("1.1", "", "\"1.2\"", local, "");
  const auto with = [&good](const std::string& what, const std::string& by) {
    std::string text = good;
    return text.replace(text.find(what), what.size(), by);
  };
  const std::pair<std::string, const char*> cases[] = {
      {good.substr(0, good.size() / 2), "no whole JSON"},
      {with("[[4,5,6,7]]", "[[4,5,6,8]]"), "CityObject b1: boundaries"},
      {with("[[4,5,6,7]]", "[[4,5,-1,7]]"), "CityObject b1: boundaries"},
      {with("[[4,5,6,7]]", "[[4,5,\"x\",7]]"), "CityObject b1: boundaries"},
      {with("\"vertices\"", "\"corners\""), "no vertices"},
      {with("\"vertices\": [", "\"vertices\": [[1,2],"), "vertex 0"},
      {with("\"CityObjects\"", "\"Objects\""), "no CityObjects"},
      {with("\"CityJSON\"", "\"CityJSONFeature\""), "no CityJSON"},
  };
  for (const auto& [text, says] : cases) {
    const auto read = ParseCityJson(text, "city.json", kLocal);
    ASSERT_FALSE(read) << says;
    EXPECT_EQ(read.error().code, core::ErrorCode::kFormat);
    EXPECT_THAT(read.error().message, HasSubstr(says));
  }
  std::string letters = PlateauBuilding("EPSG:6697", false, false);
  letters.replace(letters.find("<gml:posList>") + 13, 3, "one");
  const auto read = ReadBuildings(WriteTo(folder / "b.gml", letters), {kOrigin});
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().message, HasSubstr("a coordinate that is no number"));
}

}  // namespace
}  // namespace kawara::gis
