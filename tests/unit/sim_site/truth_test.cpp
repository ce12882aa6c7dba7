#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "committed_sites.hpp"
#include "sim/site/polygon.hpp"
#include "sim/site/reference_model.hpp"
#include "sim/site/text_file.hpp"
#include "sim/site/truth_geopackage.hpp"
#include "sim/site/truth_objects.hpp"

namespace kawara::sim {
namespace {

std::string ReadAll(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::vector<std::string> Split(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream in(line);
  for (std::string field; std::getline(in, field, ',');) fields.push_back(field);
  return fields;
}

class Truth : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("kawara_truth_" + std::to_string(::getpid()) + "_" +
               testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string File(const std::string& name) const { return (folder_ / name).string(); }
  std::filesystem::path folder_;
};

TEST(Apexes, AreTheCornersInTheirOrder) {
  const UprightBox box{{10, 20, 3}, {4, 2, 1}, core::kPi / 2};  // heading east
  const auto a = Apexes(box);
  const std::array<Eigen::Vector3d, 8> expected{
      Eigen::Vector3d(12, 21, 2.5), Eigen::Vector3d(8, 21, 2.5),  Eigen::Vector3d(8, 19, 2.5),
      Eigen::Vector3d(12, 19, 2.5), Eigen::Vector3d(12, 21, 3.5), Eigen::Vector3d(8, 21, 3.5),
      Eigen::Vector3d(8, 19, 3.5),  Eigen::Vector3d(12, 19, 3.5)};
  for (std::size_t i = 0; i < 8; ++i) EXPECT_LT((a[i] - expected[i]).norm(), 1e-9) << i;
}

TEST_F(Truth, CsvHoldsEveryStandingObjectWithItsApexes) {
  const Scene& scene = Built("factory_road").after;
  ASSERT_TRUE(WriteObjectsCsv(scene, File("objects.csv")));
  std::istringstream lines(ReadAll(File("objects.csv")));
  std::string line;
  ASSERT_TRUE(std::getline(lines, line));
  std::map<std::string, std::size_t> column;
  for (const std::string& name : Split(line)) column.emplace(name, column.size());
  ASSERT_EQ(column.size(), 13U + 24U);
  const core::LocalEnu enu(scene.origin);
  std::size_t rows = 0;
  const std::vector<SceneObject> objects = StandingObjects(scene);
  for (; std::getline(lines, line); ++rows) {
    const auto fields = Split(line);
    ASSERT_EQ(fields.size(), column.size());
    const SceneObject& object = objects.at(rows);
    EXPECT_EQ(fields[column["name"]], object.name);
    EXPECT_EQ(fields[column["in_reference"]], object.in_reference ? "1" : "0");
    for (std::size_t i = 0; i < 8; ++i) {
      const std::string apex = "apex" + std::to_string(i);
      const Eigen::Vector3d p =
          enu.FromGeodetic({std::stod(fields[column[apex + "_lat_deg"]]) * core::kRadFromDeg,
                            std::stod(fields[column[apex + "_lon_deg"]]) * core::kRadFromDeg,
                            std::stod(fields[column[apex + "_h_m"]])});
      EXPECT_LT((p - Apexes(VisibleBox(object))[i]).norm(), 2e-4) << object.name;
    }
  }
  EXPECT_EQ(rows, objects.size());
}

TEST_F(Truth, VisibleBoxesStandOnTheGroundWithTheirTopsKept) {
  const BuiltSite& built = Built("residential_collapse");
  const Terrain terrain(built.site);
  bool buried = false;
  for (const SceneObject& object : StandingObjects(built.after)) {
    const UprightBox box = VisibleBox(object);
    EXPECT_NEAR(box.centre_enu_m.z() + box.size_m.z() / 2,
                object.box.centre_enu_m.z() + object.box.size_m.z() / 2, 1e-9);
    if (object.buried_m == 0.0) continue;
    buried = true;
    // Nowhere under the box is the ground lower; somewhere it is as low.
    std::vector<Eigen::Vector2d> floor;
    for (std::size_t i = 0; i < 4; ++i) floor.push_back(Apexes(box)[3 - i].head<2>());
    EXPECT_NEAR(terrain.HeightRange(floor)[0], Apexes(box)[0].z(), 0.02) << object.name;
  }
  EXPECT_TRUE(buried);
}

TEST_F(Truth, TimesOfExistenceAreWritten) {
  ASSERT_TRUE(WriteObjectsCsv(Built("warehouse_yard").after, File("objects.csv")));
  EXPECT_NE(ReadAll(File("objects.csv")).find(",shuttle,car,0,20.000,90.000,"), std::string::npos);
}

TEST_F(Truth, ReferenceShellsAreClosedFaceOutwardsAndHoldTheirVolume) {
  for (const char* name : kCommittedSites) {
    const SiteConfig& site = Built(name).site;
    for (const ReferenceBuilding& b : ReferenceBuildings(site, Terrain(site))) {
      Eigen::Vector3d net = Eigen::Vector3d::Zero();
      double volume = 0.0;
      for (const auto& surface : b.surfaces) {
        const auto& ring = surface.ring_enu_m;
        for (std::size_t i = 2; i < ring.size(); ++i) {
          const Eigen::Vector3d o(b.footprint_enu_m[0].x(), b.footprint_enu_m[0].y(), b.ground_m);
          const Eigen::Vector3d p = ring[0] - o, q = ring[i - 1] - o, r = ring[i] - o;
          net += (q - p).cross(r - p) / 2.0;
          volume += p.dot(q.cross(r)) / 6.0;
        }
      }
      const double floor_m2 = SignedArea(b.footprint_enu_m);
      EXPECT_LT(net.norm(), 1e-6 * floor_m2) << b.name;
      EXPECT_GE(volume, floor_m2 * (b.eaves_m - b.ground_m) - 1e-6) << b.name;
      EXPECT_LE(volume, floor_m2 * (b.top_m - b.ground_m) + 1e-6) << b.name;
    }
  }
}

TEST_F(Truth, ReferenceKnowsTheHouseThatFellButNotItsHeap) {
  const SiteConfig& site = Built("residential_collapse").site;
  const Terrain terrain(site);
  bool house = false;
  for (const ReferenceBuilding& b : ReferenceBuildings(site, terrain)) {
    house |= b.name == "fallen-house";
    EXPECT_EQ(b.name.find("rubble"), std::string::npos);
  }
  EXPECT_TRUE(house);
}

TEST_F(Truth, ReferenceBlocksEncloseTheWallsOfTheScene) {
  const BuiltSite& built = Built("factory_road");
  const Terrain terrain(built.site);
  std::map<std::string, const SceneObject*> objects;
  for (const SceneObject& object : built.before.objects) objects[object.name] = &object;
  for (const ReferenceBuilding& b : ReferenceBuildings(built.site, terrain)) {
    const UprightBox& box = objects.at(b.name)->box;
    constexpr double kFittings_m = 0.5;  // ridge tiles, copings
    EXPECT_NEAR(box.centre_enu_m.z() + box.size_m.z() / 2, b.top_m, kFittings_m) << b.name;
  }
}

TEST_F(Truth, RoadPolygonHasTheRoadsArea) {
  const SiteConfig site = EmptySite();
  const Terrain terrain(site);
  std::vector<Eigen::Vector2d> ring;
  for (const Eigen::Vector3d& p : RoadPolygon(site, terrain, false)) ring.push_back(p.head<2>());
  EXPECT_TRUE(IsSimplePolygon(ring));
  EXPECT_NEAR(SignedArea(ring), 70.0 * site.road.width_m, 1e-6);
}

TEST_F(Truth, FilesAreTheSameBytesEachTime) {
  const BuiltSite& built = Built("factory_road");
  const Terrain terrain(built.site);
  for (const std::string suffix : {"1", "2"}) {
    ASSERT_TRUE(WriteObjectsGeoJson(built.after, File("objects" + suffix)));
    ASSERT_TRUE(WriteReferenceCityJson(built.site, terrain, File("city" + suffix)));
    ASSERT_TRUE(WriteRoadGeoJson(built.site, terrain, File("road" + suffix)));
    ASSERT_TRUE(WriteTruthGeoPackage(built.after, built.site, terrain, File("truth" + suffix)));
  }
  for (const std::string name : {"objects", "city", "road", "truth"}) {
    const std::string text = ReadAll(File(name + "1"));
    EXPECT_GT(text.size(), 500U) << name;
    EXPECT_EQ(text, ReadAll(File(name + "2"))) << name;
  }
}

TEST_F(Truth, FolderThatIsNotThereIsSaid) {
  const BuiltSite& built = Built("factory_road");
  const auto csv = WriteObjectsCsv(built.after, File("no/objects.csv"));
  ASSERT_FALSE(csv);
  EXPECT_EQ(csv.error().code, core::ErrorCode::kNotFound);
  EXPECT_FALSE(
      WriteTruthGeoPackage(built.after, built.site, Terrain(built.site), File("no/t.gpkg")));
}

TEST(TextFile, NumbersHaveNoNegativeZero) {
  EXPECT_EQ(Fixed(-0.0, 2), "0.00");
  EXPECT_EQ(Fixed(-0.001, 2), "0.00");
  EXPECT_EQ(Fixed(-1.005, 1), "-1.0");
}

TEST(TextFile, NamesAreEscaped) {
  EXPECT_EQ(JsonText("a\"b\\\n"), "\"a\\\"b\\\\\\u000a\"");
  EXPECT_EQ(CsvText("a,\"b\""), "\"a,\"\"b\"\"\"");
}

}  // namespace
}  // namespace kawara::sim
