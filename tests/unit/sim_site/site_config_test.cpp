#include "sim/site/site_config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>

#include "committed_sites.hpp"
#include "core/config/config.hpp"
#include "sim/site/road_line.hpp"

namespace kawara::sim {
namespace {

using ::testing::HasSubstr;

const std::string kHead = R"(name: small
seed: 3
origin: {lat_deg: 35, lon_deg: 139, h_ellipsoidal_m: 10}
sun: {azimuth_deg: 180, elevation_deg: 40}
terrain: {west_m: -40, south_m: -30, east_m: 40, north_m: 30}
road: {points_m: [[-35, 0], [35, 0]], width_m: 6}
path: {speed_mps: 1, points: [{at_m: [-30, 0]}, {at_m: [30, 0]}]}
)";

core::Expected<SiteConfig> Parse(const std::string& yaml) {
  return core::config::Parse<SiteConfig>(yaml, "small.yaml");
}

TEST(SiteConfig, SmallestSiteLoads) {
  const auto site = Parse(kHead);
  ASSERT_TRUE(site) << site.error().message;
  EXPECT_EQ(site->seed, 3U);
  EXPECT_DOUBLE_EQ(site->origin.Geodetic().lat_rad, 35 * core::kRadFromDeg);
}

TEST(SiteConfig, MissingFileIsSaid) {
  const auto site = LoadSite("/nowhere/site.yaml");
  ASSERT_FALSE(site);
  EXPECT_EQ(site.error().code, core::ErrorCode::kNotFound);
}

class CommittedSiteFile : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, CommittedSiteFile, testing::ValuesIn(kCommittedSites));

TEST_P(CommittedSiteFile, LoadsWithAtLeast100MetresOfRoadAndWay) {
  const SiteConfig site = LoadCommitted(GetParam());
  EXPECT_EQ(site.name, GetParam());
  EXPECT_GE(RoadLength(site.road), 100.0);
  double way_m = 0.0;
  for (std::size_t i = 0; i + 1 < site.path.points.size(); ++i)
    way_m += std::hypot(site.path.points[i + 1].at_m[0] - site.path.points[i].at_m[0],
                        site.path.points[i + 1].at_m[1] - site.path.points[i].at_m[1]);
  EXPECT_GE(way_m, 100.0);
  EXPECT_LE(way_m, 220.0);
}

TEST_P(CommittedSiteFile, DumpReadsBackAsTheSameSite) {
  const SiteConfig site = LoadCommitted(GetParam());
  const std::string dumped = core::config::Dump(site);
  const auto again = Parse(dumped);
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(core::config::Dump(*again), dumped);
}

struct Mistake {
  const char* yaml;       ///< appended to the small site, from line 8 on
  const char* complaint;  ///< place and key
};
class SiteMistake : public testing::TestWithParam<Mistake> {};
TEST_P(SiteMistake, IsReportedWithItsPlace) {
  const auto site = Parse(kHead + GetParam().yaml);
  ASSERT_FALSE(site);
  EXPECT_THAT(site.error().message, HasSubstr(GetParam().complaint));
}
INSTANTIATE_TEST_SUITE_P(
    Table, SiteMistake,
    testing::Values(
        Mistake{"builds: []\n", "small.yaml:8:1: builds"},
        Mistake{"things: [{kind: car}]\n", "small.yaml:8:10: things[0].at_m: missing"},
        Mistake{"things: [{kind: cat, at_m: [0, 0]}]\n", "small.yaml:8:17: things[0].kind = cat"},
        Mistake{"things: [{kind: car, at_m: [0]}]\n", "small.yaml:8:28: things[0].at_m"},
        Mistake{"things: [{kind: car, at_m: [0, 0], state: lost}]\n", "things[0].state = lost"},
        Mistake{"things: [{kind: car, at_m: [0, 0], begin_s: 9, end_s: 3}]\n",
                "things[0].end_s = 3: expected later than begin_s"},
        Mistake{
            "things: [{kind: car, at_m: [0, 0], name: a}, {kind: car, at_m: [9, 0], name: a}]\n",
            "expected every name of a thing once only"},
        Mistake{"fences: [{points_m: [[0, 0]]}]\n", "fences[0].points_m"},
        Mistake{"buildings: [{height_m: 5}]\n", "buildings[0].footprint_m"},
        Mistake{"buildings: [{height_m: 5, footprint_m: [[0, 0], [0, 9], [9, 9]]}]\n",
                "counter-clockwise"},
        Mistake{"buildings: [{height_m: 5, footprint_m: [[0, 0], [9, 9], [9, 0], [0, 9]]}]\n",
                "counter-clockwise"},
        Mistake{"buildings: [{height_m: 5, footprint_m: [[0, 0], [9, 0], [9, 9]], roof: {type: "
                "hip}}]\n",
                "a flat roof over a polygon"},
        Mistake{"buildings: [{height_m: 5, rectangle: {centre_m: [0, 0], size_m: [8, 8]}, doors: "
                "[{at_m: 7.9}]}]\n",
                "buildings[0].doors"},
        Mistake{"buildings: [{height_m: 5, storeys: 3, rectangle: {centre_m: [0, 0], size_m: [8, "
                "8]}, windows: {}}]\n",
                "buildings[0].windows"},
        Mistake{"rows: [{from_m: [0, 0], to_m: [9, 0], spacing_m: 3}]\n", "either kind or houses"},
        Mistake{"rows: [{kind: tree, from_m: [1, 0], to_m: [1, 0], spacing_m: 3}]\n",
                "rows[0].to_m"},
        Mistake{"scatter: [{kinds: [], area_m: [[0, 0], [9, 0], [9, 9]], per_100_m2: 1}]\n",
                "scatter[0].kinds"},
        Mistake{"rubble: [{at_m: [0, 0], size_m: [4, 3], height_m: -1}]\n",
                "small.yaml:8:51: rubble[0].height_m = -1: expected 0.1..12"}));

TEST(SiteConfig, RoadWhoseCornersDoNotFitIsRefused) {
  for (const char* road :
       {"{points_m: [[-35, 0], [0, 0], [0, 9]], width_m: 6, corner_radius_m: 20}",
        "{points_m: [[-35, 0], [0, 0], [0, 28]], width_m: 6, corner_radius_m: 3}",
        "{points_m: [[-35, 0], [20, 0], [-35, 1]], width_m: 6}"}) {
    std::string yaml = kHead;
    const auto begin = yaml.find("road: ") + 6;
    yaml.replace(begin, yaml.find('\n', begin) - begin, road);
    const auto site = Parse(yaml);
    ASSERT_FALSE(site) << road;
    EXPECT_THAT(site.error().message, HasSubstr("corner_radius_m"));
  }
}

TEST(SiteConfig, WayOutsideTheTerrainIsRefused) {
  std::string yaml = kHead;
  const auto at = yaml.find("[30, 0]");
  yaml.replace(at, 7, "[41, 0]");
  const auto site = Parse(yaml);
  ASSERT_FALSE(site);
  EXPECT_THAT(site.error().message, HasSubstr("small.yaml:7:7: path"));
}

TEST(SiteConfig, AllMistakesComeAtOnce) {
  const auto site = Parse(kHead +
                          "things: [{kind: cat, at_m: [0, 0]}]\n"
                          "rubble: [{at_m: [0, 0], size_m: [4, 3], height_m: 99}]\n"
                          "colour: blue\n");
  ASSERT_FALSE(site);
  const std::string& said = site.error().message;
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n') + (said.back() == '\n' ? 0 : 1), 3) << said;
}

}  // namespace
}  // namespace kawara::sim
