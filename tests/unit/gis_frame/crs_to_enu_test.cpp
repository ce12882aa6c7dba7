#include "gis/frame/crs_to_enu.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace kawara::gis {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

const core::Geodetic kTokyo{35.7 * core::kRadFromDeg, 139.7 * core::kRadFromDeg, 41.25};

TEST(CrsToEnu, GeographicWithEllipsoidalHeight) {
  auto crs = CrsToEnu::Make("EPSG:4979", {kTokyo});
  ASSERT_TRUE(crs) << crs.error().message;
  EXPECT_EQ(crs->heights(), HeightDatum::kEllipsoidal);
  EXPECT_TRUE(crs->IsNorthingFirst());
  const Vector3d p = crs->Exact({139.701, 35.7005, 50.0});
  const Vector3d want = core::LocalEnu(kTokyo).FromGeodetic(
      {35.7005 * core::kRadFromDeg, 139.701 * core::kRadFromDeg, 50.0});
  EXPECT_LT((p - want).norm(), 1e-6);
}

TEST(CrsToEnu, HeightsAboveTheSeaAreLifted) {
  // JGD2011 with heights above Tokyo Bay, as PLATEAU's models.
  for (const char* name :
       {"EPSG:6697", "urn:ogc:def:crs:EPSG::6697", "http://www.opengis.net/def/crs/EPSG/0/6697"}) {
    auto crs = CrsToEnu::Make(name, {kTokyo, Coordinates::kFromFile, 36.5});
    ASSERT_TRUE(crs) << crs.error().message;
    EXPECT_EQ(crs->heights(), HeightDatum::kSeaLevel);
    EXPECT_TRUE(crs->IsNorthingFirst());
    const Vector3d p = crs->Exact({139.7, 35.7, 4.75});
    EXPECT_LT(p.norm(), 0.001) << p.transpose();
  }
}

TEST(CrsToEnu, JapanesePlaneTakesEastingFirst) {
  auto crs = CrsToEnu::Make("EPSG:6677", {kTokyo});  // zone IX: x north, y east, of 36 N 139.8333 E
  ASSERT_TRUE(crs) << crs.error().message;
  EXPECT_TRUE(crs->IsNorthingFirst());
  const Vector3d here = crs->Exact({-12'000.0, -33'000.0, 0.0});
  const Vector3d east = crs->Exact({-11'900.0, -33'000.0, 0.0});
  EXPECT_GT((east - here).x(), 99.9);
  EXPECT_LT(std::abs((east - here).y()), 0.3);
  EXPECT_LT(here.head<2>().norm(), 1000.0);
}

TEST(CrsToEnu, FeetAreMetresInTheMap) {
  // California zone 3, US survey feet, without a height system: heights in feet as well.
  const core::Geodetic oakland{37.8 * core::kRadFromDeg, -122.2 * core::kRadFromDeg, 0.0};
  auto crs = CrsToEnu::Make("EPSG:2227", {oakland});
  ASSERT_TRUE(crs) << crs.error().message;
  const Eigen::Vector2d at = crs->Back({0, 0, 0});
  const Vector3d a = crs->Exact({at.x(), at.y(), 0.0});
  const Vector3d b = crs->Exact({at.x() + 1000.0, at.y(), 100.0});
  EXPECT_LT(a.head<2>().norm(), 0.001);
  EXPECT_NEAR((b - a).z(), 30.48, 0.02);
  EXPECT_NEAR((b - a).head<2>().norm(), 304.8, 0.05);
}

TEST(CrsToEnu, TheFitIsTheFormulaToHalfAMillimetre) {
  for (const char* name : {"EPSG:32654", "EPSG:6677", "EPSG:4326"}) {
    auto crs = CrsToEnu::Make(name, {kTokyo, Coordinates::kFromFile, 30.0});
    ASSERT_TRUE(crs);
    const Eigen::Vector2d middle = crs->Back({0, 0, 0});
    const double unit = std::string(name) == "EPSG:4326" ? 1e-5 : 1.0;
    std::vector<Vector3d> fitted, exact;
    for (int i = 0; i < 2000; ++i) {
      const Vector3d p(middle.x() + unit * 1.37 * (i - 1000), middle.y() + unit * ((i * 37) % 901),
                       (i % 50) * 3.0);
      fitted.push_back(p);
      exact.push_back(crs->Exact(p));
    }
    crs->Convert(fitted);
    for (std::size_t i = 0; i < fitted.size(); ++i)
      ASSERT_LT((fitted[i] - exact[i]).norm(), CrsToEnu::kFitTolerance_m) << name << i;
  }
}

TEST(CrsToEnu, BackAndForth) {
  auto crs = CrsToEnu::Make("EPSG:6677", {kTokyo});
  ASSERT_TRUE(crs);
  const Vector3d enu_m(812.25, -431.5, 3.0);
  const Eigen::Vector2d xy = crs->Back(enu_m);
  const double h = core::LocalEnu(kTokyo).ToGeodetic(enu_m).h_ellipsoidal_m;
  EXPECT_LT((crs->Exact({xy.x(), xy.y(), h}) - enu_m).norm(), 0.001);
  EXPECT_NEAR(crs->UpOf(enu_m.head<2>(), h), 3.0, 1e-5);
}

TEST(CrsToEnu, WhereTheSystemIsNotDefinedIsNan) {
  auto crs = CrsToEnu::Make("EPSG:32654", {kTokyo});
  ASSERT_TRUE(crs);
  std::vector<Vector3d> points{{1e300, 0, 0}, {std::nan(""), 0, 0}, {0, -1e12, 0}};
  crs->Convert(points);
  for (const Vector3d& p : points) EXPECT_FALSE(p.allFinite()) << p.transpose();
}

TEST(CrsToEnu, RefusalsNameTheSystem) {
  for (const auto& [name, says] : {std::pair{"EPSG:999999", "EPSG:999999"},
                                   {"", "not known"},
                                   {"EPSG:4978", "earth-centred"},
                                   {"LOCAL_CS[\"site grid\",UNIT[\"metre\",1]]", "site grid"}}) {
    const auto crs = CrsToEnu::Make(std::string(name), {kTokyo});
    ASSERT_FALSE(crs) << name;
    EXPECT_EQ(crs.error().code, core::ErrorCode::kInvalidArgument);
    EXPECT_THAT(crs.error().message, HasSubstr(says));
  }
}

}  // namespace
}  // namespace kawara::gis
