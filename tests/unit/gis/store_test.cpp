#include "gis/store.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <random>

#include "fixture.hpp"

namespace kawara::gis {
namespace {

using namespace testing;
using ::testing::HasSubstr;
using ::testing::Not;

#define ASSERT_OK(expression)                        \
  do {                                               \
    const auto& result_ = (expression);              \
    ASSERT_TRUE(result_) << result_.error().message; \
  } while (false)

SpatioTemporalStore OpenAt(const std::filesystem::path& path) {
  auto store = SpatioTemporalStore::Open({.target = path.string()});
  if (!store) throw std::runtime_error(store.error().message);
  return std::move(*store);
}

/// A column of one row: Value(dump, "obs_pose", 0, "t_end").
std::string Value(const std::string& dump, const std::string& layer, int row,
                  const std::string& column) {
  std::istringstream lines(dump);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind(layer + "\t", 0) != 0 || row-- > 0) continue;
    const std::size_t at = line.find("\t" + column + "=");
    if (at == std::string::npos) return "no such column";
    const std::size_t begin = at + column.size() + 2;
    return line.substr(begin, line.find('\t', begin) - begin);
  }
  return "no such row";
}

class Store : public ::testing::Test {
 protected:
  std::filesystem::path path() const { return folder_ / "store.gpkg"; }
  TestFolder folder_;
};

TEST_F(Store, KeepsEveryColumnOfAPose) {
  auto store = OpenAt(path());
  ASSERT_OK(store.AddPose(Pose(0.5)));
  ASSERT_OK(store.Close());
  const std::string dump = Dump(path());
  const std::vector<std::pair<std::string, std::string>> expected{
      {"robot", "rover-1"},
      {"mission", "20261122T062523Z"},
      {"class_code", "obs.pose"},
      {"gps_ns", std::to_string((kStart + core::Milliseconds(500)).ns())},
      {"t_begin", "2026-11-22T06:25:23.500Z"},
      {"t_end", "NULL"},
      {"lat_deg", "35.706105"},
      {"lon_deg", "139.7061035"},
      {"h_ellipsoidal_m", "61.25"},
      {"roll_deg", "0.5"},
      {"pitch_deg", "-1.25"},
      {"yaw_deg", "33"},
      {"v_east_mps", "0.6"},
      {"v_north_mps", "1.1"},
      {"v_up_mps", "0"},
      {"sd_east_m", "0.011"},
      {"sd_north_m", "0.012"},
      {"sd_up_m", "0.02"},
      {"sd_roll_deg", "0.1"},
      {"sd_pitch_deg", "0.1"},
      {"sd_yaw_deg", "0.4"},
      {"rtk_state", "fixed"},
      {"gnss_age_s", "0.05"},
      {"source", "periodic"},
      {"geom", "POINT Z (139.7061035 35.706105 61.25)"}};
  for (const auto& [column, value] : expected)
    EXPECT_EQ(Value(dump, "obs_pose", 0, column), value) << column;
}

TEST_F(Store, UnknownFiguresAreNull) {
  auto store = OpenAt(path());
  PoseRecord pose = Pose(0);
  pose.pose.gnss_age_s = std::nan("");
  pose.pose.position_sd_enu_m[2] = std::nan("");
  ASSERT_OK(store.AddPose(pose));
  ASSERT_OK(store.Close());
  const std::string dump = Dump(path());
  EXPECT_EQ(Value(dump, "obs_pose", 0, "gnss_age_s"), "NULL");
  EXPECT_EQ(Value(dump, "obs_pose", 0, "sd_up_m"), "NULL");
  EXPECT_EQ(Value(dump, "obs_pose", 0, "sd_north_m"), "0.012");
}

TEST_F(Store, APoseExistsUntilTheNextOfItsRobot) {
  auto store = OpenAt(path());
  ASSERT_OK(store.AddPose(Pose(0)));
  ASSERT_OK(store.AddPose(Pose(0.5, "rover-2")));
  ASSERT_OK(store.AddPose(Pose(1)));
  ASSERT_OK(store.AddPose(Pose(60, "rover-1", "the-next-mission")));
  ASSERT_OK(store.Close());
  const std::string dump = Dump(path());
  EXPECT_EQ(Value(dump, "obs_pose", 0, "t_end"), "2026-11-22T06:25:24.000Z");
  EXPECT_EQ(Value(dump, "obs_pose", 1, "t_end"), "2026-11-22T06:26:23.000Z");
  EXPECT_EQ(Value(dump, "obs_pose", 2, "t_end"), "NULL");
  EXPECT_EQ(Value(dump, "obs_pose", 3, "t_end"), "NULL");
}

TEST_F(Store, AFullPictureTakesThePlaceOfItsPreview) {
  auto store = OpenAt(path());
  ASSERT_OK(store.AddPanorama(Panorama(7, PictureStage::kPreview)));
  ASSERT_OK(store.Flush());
  std::string dump = Dump(path());
  EXPECT_EQ(Value(dump, "obs_panorama", 0, "stage"), "preview");
  EXPECT_EQ(Value(dump, "obs_panorama", 0, "uri"),
            "pictures/rover-1/20261122T062523Z/000007_preview.jpg");
  ASSERT_OK(store.AddPanorama(Panorama(7, PictureStage::kFull)));
  ASSERT_OK(store.Close());
  dump = Dump(path());
  EXPECT_THAT(dump, HasSubstr("# obs_panorama: 1 rows"));
  EXPECT_EQ(Value(dump, "obs_panorama", 0, "stage"), "full");
  EXPECT_EQ(Value(dump, "obs_panorama", 0, "width_px"), "512");
  EXPECT_EQ(Value(dump, "obs_panorama", 0, "uri"), "pictures/rover-1/20261122T062523Z/000007.jpg");
  EXPECT_EQ(Value(dump, "obs_panorama", 0, "preview_uri"),
            "pictures/rover-1/20261122T062523Z/000007_preview.jpg");
  EXPECT_EQ(store.stats().upgrades, 1U);
}

TEST_F(Store, APictureWithoutAPlaceIsKept) {
  auto store = OpenAt(path());
  PanoramaRecord picture = Panorama(1, PictureStage::kFull);
  picture.has_position = false;
  picture.pose.lat_deg = std::nan("");
  ASSERT_OK(store.AddPanorama(picture));
  ASSERT_OK(store.Close());
  const std::string dump = Dump(path());
  EXPECT_EQ(Value(dump, "obs_panorama", 0, "geom"), "NULL");
  EXPECT_EQ(Value(dump, "obs_panorama", 0, "lat_deg"), "NULL");
  EXPECT_EQ(Value(dump, "obs_panorama", 0, "t_begin"), "2026-11-22T06:25:24.000Z");
}

TEST_F(Store, ThePoseOfAPictureWinsOverAPeriodicOneOfTheSameInstant) {
  auto store = OpenAt(path());
  PoseRecord exposure = Pose(1);
  exposure.at_exposure = true;
  for (const auto& pose : {Pose(1), exposure, Pose(1)}) ASSERT_OK(store.AddPose(pose));
  ASSERT_OK(store.Close());
  const std::string dump = Dump(path());
  EXPECT_THAT(dump, HasSubstr("# obs_pose: 1 rows"));
  EXPECT_EQ(Value(dump, "obs_pose", 0, "source"), "exposure");
}

TEST_F(Store, TheTrajectoryHoldsEveryPoseWithItsTime) {
  auto store = OpenAt(path());
  for (int i = 0; i < 3; ++i) ASSERT_OK(store.AddPose(Pose(i)));
  ASSERT_OK(store.Close());
  const std::string dump = Dump(path());
  EXPECT_EQ(Value(dump, "trajectory", 0, "poses"), "3");
  EXPECT_EQ(Value(dump, "trajectory", 0, "t_begin"), "2026-11-22T06:25:23.000Z");
  EXPECT_EQ(Value(dump, "trajectory", 0, "t_end"), "2026-11-22T06:25:25.000Z");
  // Two steps of 1e-5 deg north (1.1097 m at 35.7 deg) and 0.7e-5 deg east (0.6338 m).
  EXPECT_NEAR(std::stod(Value(dump, "trajectory", 0, "length_m")), 2.556, 0.002);
  EXPECT_EQ(
      Value(dump, "trajectory", 0, "geom"),
      "LINESTRING ZM (139.7061 35.7061 61.25 1795328723, 139.706107 35.70611 61.25 1795328724, "
      "139.706114 35.70612 61.25 1795328725)");
}

TEST_F(Store, EventsAreKeptOnce) {
  auto store = OpenAt(path());
  EventRecord no_time = Event(3, "it's \"gone\"; DROP TABLE obs_pose --");
  no_time.time = {};
  EventRecord of_another = Event(1, "a");
  of_another.robot = "rover-2";
  for (const auto& e :
       {Event(1, "a"), Event(2, "a"), Event(1, "a"), no_time, of_another, of_another})
    ASSERT_OK(store.AddEvent(e));
  ASSERT_OK(store.Close());
  const std::string dump = Dump(path());
  EXPECT_THAT(dump, HasSubstr("# event_log: 4 rows"));
  EXPECT_EQ(Value(dump, "event_log", 0, "robot"), "rover-1");
  EXPECT_EQ(Value(dump, "event_log", 3, "robot"), "rover-2");
  EXPECT_EQ(Value(dump, "event_log", 2, "text"), "it's \"gone\"; DROP TABLE obs_pose --");
  EXPECT_EQ(Value(dump, "event_log", 2, "t_begin"), "NULL");
  EXPECT_EQ(Value(dump, "event_log", 0, "severity"), "warn-low");
}

/// Adds the records of a small mission in the order of `seed`, some of them twice, flushing now and
/// then.
void Fill(const std::filesystem::path& path, unsigned seed) {
  std::vector<std::function<core::Expected<void>(SpatioTemporalStore&)>> steps;
  for (int i = 1; i <= 12; ++i) {
    steps.push_back([i](auto& s) { return s.AddPose(Pose(i * 0.7)); });
    steps.push_back([i](auto& s) { return s.AddPanorama(Panorama(i, PictureStage::kPreview)); });
    steps.push_back([i](auto& s) { return s.AddPanorama(Panorama(i, PictureStage::kFull)); });
    steps.push_back([i](auto& s) { return s.AddEvent(Event(i, "again")); });
  }
  std::mt19937 random(seed);
  if (seed != 0) {
    const std::vector again(steps.begin(), steps.begin() + 20);
    steps.insert(steps.end(), again.begin(), again.end());
    std::shuffle(steps.begin(), steps.end(), random);
  }
  auto store = OpenAt(path);
  for (const auto& step : steps) {
    ASSERT_OK(step(store));
    if (random() % 5 == 0) ASSERT_OK(store.Flush());
    if (seed != 0 && random() % 25 == 0) {
      ASSERT_OK(store.Close());
      store = OpenAt(path);
    }
  }
  ASSERT_OK(store.Close());
}

TEST_F(Store, ContentDoesNotDependOnOrderBatchesOrRepetition) {
  Fill(folder_ / "in_order/store.gpkg", 0);
  const std::string expected = Dump(folder_ / "in_order/store.gpkg");
  EXPECT_THAT(expected, HasSubstr("# obs_panorama: 12 rows"));
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const auto other = folder_ / (std::to_string(seed) + "/store.gpkg");
    Fill(other, seed);
    EXPECT_EQ(Dump(other), expected) << "seed " << seed;
  }
}

TEST_F(Store, NoWallClockInTheFile) {
  Fill(path(), 0);
  const std::string contents =
      Shell("sqlite3 " + path().string() +
            " 'select table_name, last_change from gpkg_contents order by 1'");
  EXPECT_EQ(contents,
            "event_log|2026-11-22T06:25:35.000Z\n"
            "layer_styles|1980-01-06T00:00:00.000Z\n"
            "obs_panorama|2026-11-22T06:25:35.000Z\n"
            "obs_pose|2026-11-22T06:25:31.400Z\n"
            "trajectory|2026-11-22T06:25:31.400Z\n");
}

TEST_F(Store, CloseLeavesOneFile) {
  Fill(path(), 0);
  EXPECT_FALSE(std::filesystem::exists(path().string() + "-wal"));
  EXPECT_FALSE(std::filesystem::exists(path().string() + "-shm"));
}

TEST_F(Store, PassesGdalsGeoPackageValidation) {
  Fill(path(), 0);
  Shell("/usr/bin/python3 -m osgeo_utils.samples.validate_gpkg --extra " + path().string());
}

TEST_F(Store, OtherProgramsSeeTheLayers) {
  Fill(path(), 0);
  const std::string info = Shell("ogrinfo -so -al " + path().string());
  for (const char* part :
       {"Layer name: obs_pose", "Layer name: obs_panorama", "Layer name: trajectory",
        "Geometry: 3D Point", "Geometry: 3D Measured Line String", "ID[\"EPSG\",4326]",
        "t_begin: DateTime (0.0) NOT NULL", "t_end: DateTime (0.0)",
        "gps_ns: Integer64 (0.0) NOT NULL", "rtk_state: String", "Feature Count: 12",
        "Extent: (139.706105, 35.706107)"})
    EXPECT_THAT(info, HasSubstr(part));
  // The time rule as any SQL client would ask it: what was there 3 s into the mission?
  const std::string at = Shell(
      "ogrinfo -q " + path().string() +
      " -sql \"select epoch, t_begin, t_end from obs_panorama where t_begin <= "
      "'2026-11-22T06:25:26.500Z' and (t_end is null or t_end > '2026-11-22T06:25:26.500Z')\"");
  EXPECT_THAT(at, HasSubstr("epoch (Integer64) = 3"));
  EXPECT_THAT(at, Not(HasSubstr("OGRFeature(SELECT):1")));
}

TEST_F(Store, AReaderSeesWhatIsFlushedWhileWeWrite) {
  auto store = OpenAt(path());
  ASSERT_OK(store.AddPose(Pose(0)));
  ASSERT_OK(store.Flush());
  EXPECT_THAT(Dump(path()), HasSubstr("# obs_pose: 1 rows"));
  ASSERT_OK(store.AddPose(Pose(1)));
  EXPECT_THAT(Dump(path()), HasSubstr("# obs_pose: 1 rows"));
  ASSERT_OK(store.Close());
}

TEST_F(Store, AddsItsLayersToAMapThatIsThereAlready) {
  Shell("ogr2ogr -f GPKG " + path().string() +
        " '{\"type\":\"Point\",\"coordinates\":[139.7,35.7]}' -nln base_map");
  Fill(path(), 0);
  EXPECT_THAT(Shell("ogrinfo -q " + path().string()), HasSubstr("base_map"));
  EXPECT_THAT(Dump(path()), HasSubstr("# obs_panorama: 12 rows"));
}

TEST_F(Store, ADeletedStoreIsMadeAnew) {
  auto store = OpenAt(path());
  ASSERT_OK(store.AddPose(Pose(0)));
  ASSERT_OK(store.Flush());
  for (const char* suffix : {"", "-wal", "-shm"}) std::filesystem::remove(path().string() + suffix);
  ASSERT_OK(store.AddPose(Pose(1)));
  ASSERT_OK(store.Close());
  EXPECT_THAT(Dump(path()), HasSubstr("# obs_pose: 1 rows"));
}

TEST_F(Store, PicturesMayLieElsewhere) {
  auto store = SpatioTemporalStore::Open(
      {.target = (folder_ / "a/store.gpkg").string(), .pictures_dir = folder_ / "b/photos/"});
  ASSERT_OK(store);
  ASSERT_OK(store->AddPanorama(Panorama(1, PictureStage::kFull)));
  ASSERT_OK(store->Close());
  EXPECT_EQ(Value(Dump(folder_ / "a/store.gpkg"), "obs_panorama", 0, "uri"),
            "../b/photos/rover-1/20261122T062523Z/000001.jpg");
}

}  // namespace
}  // namespace kawara::gis
