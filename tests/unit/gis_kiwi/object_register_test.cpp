#include "gis/kiwi/object_register.hpp"

#include <gmock/gmock.h>

#include "fixture.hpp"

namespace kawara::gis {
namespace {

using namespace testing;
using ::testing::HasSubstr;

class Register : public ::testing::Test {
 protected:
  std::filesystem::path path() const { return folder_ / "changes.gpkg"; }
  std::string Query(const std::string& sql) const { return Sql(path(), sql); }
  TestFolder folder_;
};

/// Everything but the box, which went through degrees.
void ExpectSame(const core::ChangedObject& a, const core::ChangedObject& b) {
  EXPECT_EQ(a.uid, b.uid);
  EXPECT_EQ(a.revision, b.revision);
  EXPECT_EQ(a.state, b.state);
  EXPECT_LT((a.box.centre_m - b.box.centre_m).norm(), 1e-7);
  EXPECT_EQ(a.box.size_m, b.box.size_m);
  EXPECT_NEAR(a.box.heading_rad, b.box.heading_rad, 1e-12);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.side_seen, b.side_seen);
  EXPECT_EQ(a.second_heading_rad.has_value(), b.second_heading_rad.has_value());
  EXPECT_NEAR(a.second_heading_rad.value_or(0), b.second_heading_rad.value_or(0), 1e-12);
  EXPECT_EQ(a.existence_probability, b.existence_probability);
  EXPECT_EQ(a.size_class, b.size_class);
  EXPECT_EQ(a.class_probability, b.class_probability);
  EXPECT_EQ(a.voxels, b.voxels);
  EXPECT_EQ(a.votes, b.votes);
  EXPECT_EQ(a.last_absent, b.last_absent);
  EXPECT_EQ(a.first_seen, b.first_seen);
  EXPECT_EQ(a.last_seen, b.last_seen);
  EXPECT_EQ(a.gone, b.gone);
  EXPECT_EQ(a.robots, b.robots);
}

TEST_F(Register, GivesEveryFieldOfAnObjectBack) {
  const core::ChangedObject truck = Truck();
  ASSERT_OK(OpenRegister(path()).Register(truck));
  const auto objects = OpenRegister(path()).ObjectsAt(At(1000));
  ASSERT_OK(objects);
  ASSERT_EQ(objects->size(), 1U);
  ExpectSame(objects->front(), truck);
}

TEST_F(Register, GivesAnObjectWithBareFieldsBack) {
  core::ChangedObject bare = Truck();
  bare.second_heading_rad.reset();
  bare.side_seen = {};
  bare.last_absent = {};
  bare.robots.clear();
  ASSERT_OK(OpenRegister(path()).Register(bare));
  const auto objects = OpenRegister(path()).ObjectsAt(At(1000));
  ASSERT_OK(objects);
  ASSERT_EQ(objects->size(), 1U);
  ExpectSame(objects->front(), bare);
}

// A next mission has an origin of its own; the thing stands where it stood.
TEST_F(Register, GivesAnObjectBackInAnotherMap) {
  const core::ChangedObject truck = Truck();
  ASSERT_OK(OpenRegister(path()).Register(truck));
  const core::Geodetic other{kOrigin.lat_rad + 1e-4, kOrigin.lon_rad - 1e-4, 40.0};
  const auto objects = OpenRegister(path(), other).ObjectsAt(At(1000));
  ASSERT_OK(objects);
  const core::LocalEnu here(kOrigin), there(other);
  const auto was = truck.box.Apexes();
  const auto is = objects->at(0).box.Apexes();
  for (std::size_t i = 0; i < 8; ++i) {
    // 900 m from one origin to the other tilt the "up" of 3 m by 0.14 mrad.
    EXPECT_LT((there.FromGeodetic(here.ToGeodetic(was[i])) - is[i]).norm(), 1e-3) << i;
  }
}

TEST_F(Register, WritesApexesToTheMillimetre) {
  const core::ChangedObject truck = Truck();
  ASSERT_OK(OpenRegister(path()).Register(truck));
  const core::LocalEnu map(kOrigin);
  const auto apexes = truck.box.Apexes();
  for (const char* table : {"changed_object", "kp_box"}) {
    for (std::size_t i = 0; i < apexes.size(); ++i) {
      const std::string apex = "apex" + std::to_string(i);
      std::istringstream row(Query("SELECT printf('%.12f %.12f %.6f'," + apex + "_lon_deg," + apex +
                                   "_lat_deg," + apex + "_h_m) FROM " + table));
      core::Geodetic g;
      ASSERT_TRUE(row >> g.lon_rad >> g.lat_rad >> g.h_ellipsoidal_m);
      g.lon_rad *= core::kRadFromDeg;
      g.lat_rad *= core::kRadFromDeg;
      EXPECT_LT((map.FromGeodetic(g) - apexes[i]).norm(), 1e-3) << table << " apex " << i;
    }
  }
}

TEST_F(Register, ANewRevisionClosesTheOldRowsAndAddsItsOwn) {
  auto reg = OpenRegister(path());
  ASSERT_OK(reg.Register(Truck(1, 2.0)));
  ASSERT_OK(reg.Register(Truck(2, 5.0)));
  ASSERT_OK(reg.Close());
  const std::string begin = "2026-11-22T12:00:00.123Z", second = "2026-11-22T12:00:05.123Z";
  const std::string expected = "1|" + begin + "|" + second + "\n2|" + second + "|";
  EXPECT_EQ(Query("SELECT revision,t_begin,t_end FROM changed_object ORDER BY revision"), expected);
  EXPECT_EQ(Query("SELECT revision,t_begin,t_end FROM kp_box ORDER BY revision"), expected);
  EXPECT_EQ(Query("SELECT id,t_begin,t_end FROM kp_connector ORDER BY id"),
            "truck-1/1|" + begin + "|" + second + "\ntruck-1/2|" + second + "|");
  EXPECT_EQ(Query("SELECT id,t_begin,t_end FROM kp_vector ORDER BY id"),
            "truck-1/1/outline|" + begin + "|" + second + "\ntruck-1/2/outline|" + second + "|");
}

TEST_F(Register, HistoryIsOnlyEverClosed) {
  auto reg = OpenRegister(path());
  const std::string history =
      "SELECT id,class_code,flags,base_elev_m,rel_height_m,t_begin,hex(geom) FROM kp_vector WHERE "
      "id='truck-1/1/outline' UNION ALL SELECT id,class_code,flags,base_elev_m,rel_height_m,"
      "t_begin,hex(geom) FROM kp_connector WHERE id='truck-1/1' UNION ALL SELECT connector_id,key,"
      "value,unit,'','','' FROM kp_attribute WHERE connector_id='truck-1/1'";
  ASSERT_OK(reg.Register(Truck(1, 2.0)));
  const std::string before = Query(history);
  ASSERT_OK(reg.Register(Truck(2, 5.0)));
  ASSERT_OK(reg.Register(Gone(Truck(2, 5.0), 90.0)));
  EXPECT_THAT(before, HasSubstr("existence_probability|0.987654"));
  EXPECT_EQ(Query(history), before);
}

TEST_F(Register, ANewValueOnTheSameBoxIsANewConnectorOnTheOldOutline) {
  auto reg = OpenRegister(path());
  core::ChangedObject later = Truck(1, 5.0);
  later.revision = 2;
  later.existence_probability = 0.5;
  ASSERT_OK(reg.Register(Truck(1, 2.0)));
  ASSERT_OK(reg.Register(later));
  EXPECT_EQ(Query("SELECT count(*), count(t_end) FROM kp_connector"), "2|1");
  EXPECT_EQ(Query("SELECT count(*), count(t_end) FROM kp_vector"), "1|0");
  later = Gone(later, 9.0);
  ASSERT_OK(reg.Register(later));
  EXPECT_EQ(Query("SELECT t_end FROM kp_vector"), "2026-11-22T12:00:09.123Z");
}

TEST_F(Register, GoneClosesAndAddsNothing) {
  auto reg = OpenRegister(path());
  ASSERT_OK(reg.Register(Truck(1, 2.0), Textures()));
  const auto answer = reg.Register(Gone(Truck(1, 3.0), 90.0));
  ASSERT_OK(answer);
  EXPECT_EQ(*answer, Registered::kClosed);
  for (const char* table : {"changed_object", "kp_box", "kp_vector", "kp_connector"})
    EXPECT_EQ(Query(std::string("SELECT count(*), max(t_end) FROM ") + table),
              "1|2026-11-22T12:01:30.123Z")
        << table;
  EXPECT_EQ(Query("SELECT count(*), max(t_end) FROM kp_texture"), "2|2026-11-22T12:01:30.123Z");
  EXPECT_EQ(Query("SELECT ended_by, ended_as FROM changed_object"), "2|gone");
  EXPECT_EQ(Query("SELECT end_min, end_max FROM kp_t_bounds"),
            "2026-11-22T12:00:03.123Z|2026-11-22T12:01:30.123Z");
}

TEST_F(Register, AGoneObjectNobodyRegisteredIsAddedAndClosed) {
  auto reg = OpenRegister(path());
  ASSERT_OK(reg.Register(Gone(Truck(), 90.0)));
  EXPECT_EQ(Query("SELECT count(*), count(t_end) FROM kp_connector"), "1|1");
  EXPECT_EQ(reg.ObjectsAt(At(89.9)).value().size(), 1U);
  EXPECT_EQ(reg.ObjectsAt(At(90.0)).value().size(), 0U);
}

// Half open: the instant of a change belongs to what came.
TEST_F(Register, ExistsFromItsBeginningUntilBeforeItsEnd) {
  auto reg = OpenRegister(path());
  ASSERT_OK(reg.Register(Truck(1, 2.0)));
  ASSERT_OK(reg.Register(Truck(2, 5.0)));
  ASSERT_OK(reg.Register(Gone(Truck(2, 5.0), 90.0)));
  const auto nanosecond = core::Nanoseconds(1);
  struct Case {
    core::UtcTime at;
    std::uint64_t revision;  ///< 0: nothing there
  };
  for (const Case& c : std::vector<Case>{{At(0) - nanosecond, 0},
                                         {At(0), 1},
                                         {At(5) - nanosecond, 1},
                                         {At(5), 2},
                                         {At(90) - nanosecond, 2},
                                         {At(90), 0}}) {
    const auto objects = reg.ObjectsAt(c.at);
    ASSERT_OK(objects);
    EXPECT_EQ(objects->empty() ? 0U : objects->front().revision, c.revision) << c.at.ns();
    EXPECT_LE(objects->size(), 1U);
  }
}

TEST_F(Register, ARevisionSentAgainChangesNothing) {
  auto reg = OpenRegister(path());
  ASSERT_OK(reg.Register(Truck(1), Textures(), At(10)));
  ASSERT_OK(reg.Register(Truck(2, 5.0), Textures(), At(10)));
  ASSERT_OK(reg.Register(Gone(Truck(2, 5.0), 90.0), {}, At(10)));
  const std::string before = Shell("sqlite3 '" + path().string() + "' .dump");
  for (const core::ChangedObject& again : {Truck(1), Truck(2, 7.0), Gone(Truck(2), 80.0)}) {
    const auto answer = reg.Register(again, Textures(), At(99));
    ASSERT_OK(answer);
    EXPECT_EQ(*answer, Registered::kKnown);
  }
  EXPECT_EQ(Shell("sqlite3 '" + path().string() + "' .dump"), before);
}

TEST_F(Register, ASecondRunGoesOn) {
  ASSERT_OK(OpenRegister(path()).Register(Truck(1)));
  auto second = OpenRegister(path());
  EXPECT_EQ(second.LastRevision("truck-1").value(), 1U);
  EXPECT_EQ(second.LastRevision("nobody").value(), 0U);
  ASSERT_OK(second.Register(Gone(Truck(1), 90.0)));
  EXPECT_EQ(second.LastRevision("truck-1").value(), 2U);
}

// It has been seen elsewhere since its last revision: there from when it was first seen there.
TEST_F(Register, AMovedObjectBeginsWhereItWasFirstSeenAnew) {
  auto reg = OpenRegister(path());
  ASSERT_OK(reg.Register(Truck(1, 2.0)));
  core::ChangedObject moved = Truck(2, 30.0);
  moved.state = core::ChangeState::kMoved;
  moved.first_seen = At(20.0);
  moved.box.centre_m.x() += 6.0;
  ASSERT_OK(reg.Register(moved));
  EXPECT_EQ(Query("SELECT t_end FROM changed_object WHERE revision = 1"),
            "2026-11-22T12:00:20.123Z");
  // Between the last look at the old place and the first at the new one it moved.
  EXPECT_EQ(Query("SELECT begin_min, begin_max FROM kp_t_bounds WHERE element_id = 'truck-1/2'"),
            "2026-11-22T12:00:02.123Z|2026-11-22T12:00:20.123Z");
}

TEST_F(Register, ItComesBackAfterItWasGone) {
  auto reg = OpenRegister(path());
  ASSERT_OK(reg.Register(Truck(1)));
  ASSERT_OK(reg.Register(Gone(Truck(1), 90.0)));
  ASSERT_OK(reg.Register(Truck(3, 200.0)));
  EXPECT_EQ(reg.ObjectsAt(At(150)).value().size(), 0U);
  EXPECT_EQ(reg.ObjectsAt(At(200)).value().size(), 1U);
}

TEST_F(Register, AttributesHangOnConnectorsOnly) {
  auto reg = OpenRegister(path());
  ASSERT_OK(reg.Register(Truck(1)));
  ASSERT_OK(reg.RegisterStations({{Station(0.5, 3.2, 1.0)}}, At(9)));
  EXPECT_EQ(Query("SELECT count(*) FROM kp_attribute WHERE connector_id NOT IN (SELECT id FROM "
                  "kp_connector)"),
            "0");
  EXPECT_EQ(Query("SELECT count(DISTINCT connector_id) FROM kp_attribute"), "2");
  EXPECT_EQ(Query("SELECT value, unit FROM kp_attribute WHERE key = 'passable_width'"), "3.2|m");
}

TEST_F(Register, EveryClassIsInTheFeatureSpaces) {
  auto reg = OpenRegister(path());
  ASSERT_OK(reg.Register(Truck(1)));
  ASSERT_OK(reg.RegisterStations({{Station(0.5, 0.2, 1.0), Station(1.0, 3.2, 1.0)}}, At(9)));
  EXPECT_EQ(Query("SELECT count(*) FROM (SELECT class_code FROM kp_vector UNION SELECT class_code "
                  "FROM kp_connector) WHERE class_code NOT IN (SELECT class_code FROM "
                  "kp_feature_space)"),
            "0");
}

// The pair of the published record: foot and height, for a box level where it stands.
TEST_F(Register, OneHeightPairHoldsALevelBox) {
  ASSERT_OK(OpenRegister(path()).Register(Truck(1)));
  EXPECT_EQ(Query("SELECT flags, abs(rel_height_m - 3.24) < 1e-3, abs(base_elev_m - 61.25) < 1e-3 "
                  "FROM kp_vector"),
            "0|1|1");
}

// 8 km from the map's origin "up" leans by 1.3 mrad: the pair spans it and says that it is lossy.
TEST_F(Register, AHeightPairThatSaysLessIsFlagged) {
  core::ChangedObject far = Truck(1);
  far.box.centre_m.x() += 8000.0;
  ASSERT_OK(OpenRegister(path()).Register(far));
  EXPECT_EQ(Query("SELECT v.flags, c.flags, abs(v.base_elev_m - min(apex0_h_m, apex1_h_m, "
                  "apex2_h_m, apex3_h_m)) < 1e-9 FROM kp_vector v, kp_connector c, kp_box"),
            "2|2|1");
}

TEST_F(Register, TransactionTimeComesFromTheCaller) {
  auto reg = OpenRegister(path());
  ASSERT_OK(reg.Register(Truck(1), {}, At(60)));
  ASSERT_OK(reg.Register(Truck(2, 5.0), {}, At(120)));
  EXPECT_EQ(Query("SELECT tx_begin, tx_end, who FROM kp_tx WHERE element_id = 'truck-1/1'"),
            "2026-11-22T12:01:00.123Z|2026-11-22T12:02:00.123Z|rover-1");
  EXPECT_EQ(Query("SELECT count(*), count(tx_end) FROM kp_tx"), "4|2");
}

TEST_F(Register, AStoreOfBeforeTheSeenShareIsGivenIt) {
  ASSERT_OK(OpenRegister(path()).Register(Truck(1), Textures()));
  Query("ALTER TABLE kp_texture DROP COLUMN seen_share");
  ASSERT_OK(OpenRegister(path()).Register(Truck(2, 5.0), Textures()));
  EXPECT_EQ(Query("SELECT revision, face, seen_share FROM kp_texture ORDER BY revision, face"),
            "1|front|\n1|left|\n2|front|1.0\n2|left|0.875");
  Query("ALTER TABLE kp_texture DROP COLUMN uri");  // never was without: another program's
  EXPECT_ANY_THROW(OpenRegister(path()));
}

TEST_F(Register, WritesTexturesBesideTheStoreBeforeTheirRows) {
  auto reg = OpenRegister(path());
  ASSERT_OK(reg.Register(Truck(1), Textures()));
  EXPECT_EQ(Query("SELECT texture_uri FROM changed_object"), "textures/truck-1/truck-1_r1.jpg");
  EXPECT_EQ(
      Query("SELECT face, uri, corner1_x_px, source, seen_share FROM kp_texture ORDER BY face"),
      "front|textures/truck-1/truck-1_r1.jpg|64.0|m1/000012|1.0\n"
      "left|textures/truck-1/truck-1_r1.jpg|40.0|m1/000012|0.875");
  EXPECT_EQ(std::filesystem::file_size(folder_ / "textures/truck-1/truck-1_r1.jpg"),
            Textures().atlas_jpeg.size());
}

TEST_F(Register, AStationIsClosedByItsNextObservation) {
  auto reg = OpenRegister(path());
  const std::vector<core::RoadStation> first{Station(0.5, 3.2, 1.0), Station(1.0, 3.4, 1.0)};
  EXPECT_EQ(reg.RegisterStations(first, At(9)).value(), 2U);
  EXPECT_EQ(reg.RegisterStations(first, At(10)).value(), 0U) << "the same again";
  EXPECT_EQ(reg.RegisterStations({{Station(0.5, 0.9, 50.0)}}, At(60)).value(), 1U);
  EXPECT_EQ(Query("SELECT along_m, passable_m, t_end IS NULL FROM road_station ORDER BY "
                  "along_m, begin_ns"),
            "0.5|3.2|0\n0.5|0.9|1\n1.0|3.4|1");
  EXPECT_EQ(Query("SELECT class_code, count(*), count(t_end) FROM kp_connector GROUP BY 1"),
            "status.road_blocked|1|0\nstatus.road_width|2|1");
  EXPECT_EQ(Query("SELECT count(*), count(t_end) FROM kp_vector"), "3|1");
}

TEST_F(Register, AStationNobodyLookedAtIsKnownFromTheGivenTime) {
  auto reg = OpenRegister(path());
  core::RoadStation unseen = Station(0.5, 0.0, 1.0);
  unseen.observed = {};
  unseen.unknown_share = 1.0;
  EXPECT_FALSE(reg.RegisterStations({{unseen}}, {}));
  EXPECT_EQ(reg.RegisterStations({{unseen}}, At(9)).value(), 1U);
  EXPECT_EQ(Query("SELECT t_begin, observed FROM road_station"), "2026-11-22T12:00:09.123Z|");
}

TEST_F(Register, NotesAModelOnce) {
  auto reg = OpenRegister(path());
  const ModelRecord model{.uri = "model/tile_0.wrl",
                          .origin = kOrigin,
                          .footprint_m = {{0, 0, 0}, {10, 0, 0}, {10, 10, 0}},
                          .begin = At(0),
                          .end = At(60)};
  EXPECT_EQ(reg.RegisterModel(model).value(), Registered::kAdded);
  EXPECT_EQ(reg.RegisterModel(model).value(), Registered::kKnown);
  EXPECT_EQ(Query("SELECT uri, rotation_to_enu, t_end FROM kp_model"),
            "model/tile_0.wrl|1 0 0 0 1 0 0 0 1|2026-11-22T12:01:00.123Z");
}

TEST_F(Register, TheSameCallsGiveTheSameRows) {
  const auto dump = [this](const std::string& name) {
    auto reg = OpenRegister(folder_ / name);
    EXPECT_TRUE(reg.Register(Truck(1), Textures(), At(10)));
    EXPECT_TRUE(reg.Register(Truck(2, 5.0), {}, At(20)));
    EXPECT_TRUE(reg.RegisterStations({{Station(0.5, 3.2, 1.0)}}, At(9)));
    EXPECT_TRUE(reg.Close());
    return Shell("sqlite3 '" + (folder_ / name).string() + "' .dump");
  };
  EXPECT_EQ(dump("a.gpkg"), dump("b.gpkg"));
}

TEST_F(Register, LeavesOneFile) {
  auto reg = OpenRegister(path());
  ASSERT_OK(reg.Register(Truck(1)));
  ASSERT_OK(reg.Close());
  EXPECT_FALSE(std::filesystem::exists(path().string() + "-wal"));
}

TEST_F(Register, SharesAFileWithTheStoreOfPosesAndPictures) {
  auto store = SpatioTemporalStore::Open({.target = path().string()});
  ASSERT_OK(store);
  ASSERT_OK(store->AddPose(Pose(0.5)));
  ASSERT_OK(store->Close());
  ASSERT_OK(OpenRegister(path()).Register(Truck(1)));
  EXPECT_EQ(Query("SELECT (SELECT count(*) FROM obs_pose), (SELECT count(*) FROM changed_object)"),
            "1|1");
}

TEST_F(Register, IsAConformantGeoPackageThatOgrReads) {
  auto reg = OpenRegister(path());
  ASSERT_OK(reg.Register(Truck(1), Textures(), At(10)));
  ASSERT_OK(reg.RegisterStations({{Station(0.5, 3.2, 1.0)}}, At(9)));
  ASSERT_OK(reg.RegisterModel({.uri = "a.glb",
                               .origin = kOrigin,
                               .footprint_m = {{0, 0, 0}, {10, 0, 0}, {10, 10, 0}},
                               .begin = At(0),
                               .end = {}}));
  ASSERT_OK(reg.Close());
  Shell("/usr/bin/python3 -m osgeo_utils.samples.validate_gpkg --extra '" + path().string() + "'");
  EXPECT_EQ(Query("SELECT table_name, geometry_type_name, z FROM gpkg_geometry_columns ORDER BY 1"),
            "changed_object|MULTIPOLYGON|1\nkp_box|POLYGON|1\nkp_connector|POINT|0\n"
            "kp_model|POLYGON|1\nkp_vector|LINESTRING|0\nroad_station|LINESTRING|1");
  const std::string json =
      Shell("ogr2ogr -f GeoJSON /vsistdout/ '" + path().string() + "' changed_object");
  EXPECT_THAT(json, HasSubstr("\"MultiPolygon\""));
  EXPECT_THAT(json, HasSubstr("\"class\": \"truck\""));
}

TEST_F(Register, SwitchesTheTimeSliderOn) {
  ASSERT_OK(OpenRegister(path()).Register(Truck(1)));
  EXPECT_EQ(Query("SELECT count(*) FROM layer_styles WHERE useAsDefault AND f_table_name IN "
                  "('changed_object', 'road_station', 'kp_vector', 'kp_connector', 'kp_box') AND "
                  "styleQML LIKE '%<temporal enabled=_1_ mode=_2_ startField=_t_begin_ "
                  "endField=_t_end_%'"),
            "5");
}

TEST_F(Register, RefusesWhatNoRegisterMayHold) {
  auto reg = OpenRegister(path());
  const auto with = [](auto change) {
    core::ChangedObject o = Truck();
    change(o);
    return o;
  };
  const std::vector<std::pair<const char*, core::ChangedObject>> cases{
      {"uid", with([](auto& o) { o.uid = "a/b"; })},
      {"uid", with([](auto& o) { o.uid = ".."; })},
      {"revision", with([](auto& o) { o.revision = 0; })},
      {"box", with([](auto& o) { o.box.size_m.z() = 0; })},
      {"box", with([](auto& o) { o.box.centre_m.x() = std::nan(""); })},
      {"covariance", with([](auto& o) { o.covariance(1, 2) = 0.5; })},
      {"covariance", with([](auto& o) { o.covariance(3, 3) = -0.5; })},
      {"existence probability", with([](auto& o) { o.existence_probability = 1.1; })},
      {"last seen", with([](auto& o) { o.last_seen = At(-1); })},
      {"last absent", with([](auto& o) { o.last_absent = At(1); })},
      {"gone", with([](auto& o) { o.gone = At(5); })},
      {"gone", with([](auto& o) { o.state = core::ChangeState::kGone; })},
      {"robots", with([](auto& o) { o.robots = {"a,b"}; })},
      {"robots", with([](auto& o) {
         o.robots = {"a", "a"};
       })}};
  for (const auto& [what, object] : cases) {
    const auto answer = reg.Register(object);
    ASSERT_FALSE(answer) << what;
    EXPECT_EQ(answer.error().code, core::ErrorCode::kInvalidArgument);
    EXPECT_THAT(answer.error().message, HasSubstr(what));
  }
  EXPECT_EQ(Query("SELECT count(*) FROM changed_object"), "0");
}

TEST_F(Register, RefusesTexturesThatContradictThemselves) {
  auto reg = OpenRegister(path());
  core::ObjectTextures torn = Textures();
  torn.atlas_jpeg.pop_back();
  EXPECT_FALSE(reg.Register(Truck(), torn));
  core::ObjectTextures outside = Textures();
  outside.faces[0].corners_px[2][0] = 65.0;
  EXPECT_FALSE(reg.Register(Truck(), outside));
  core::ObjectTextures twice = Textures();
  twice.faces[1].side = twice.faces[0].side;
  EXPECT_FALSE(reg.Register(Truck(), twice));
  core::ObjectTextures more_than_all = Textures();
  more_than_all.faces[1].seen_share = 1.01;
  EXPECT_FALSE(reg.Register(Truck(), more_than_all));
  EXPECT_EQ(Query("SELECT count(*) FROM changed_object"), "0");
}

TEST_F(Register, NothingOfAFailedCallStays) {
  auto reg = OpenRegister(path());
  ASSERT_OK(reg.Register(Truck(1)));
  // A table that takes nothing: the last one that is written.
  Sql(path(),
      "CREATE TRIGGER refuse BEFORE INSERT ON changed_object BEGIN SELECT RAISE(ABORT, 'no'); END");
  EXPECT_FALSE(reg.Register(Truck(2, 5.0), Textures()));
  EXPECT_EQ(Query("SELECT count(*), count(t_end) FROM kp_connector"), "1|0");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "textures/truck-1/truck-1_r2.jpg"));
  Sql(path(), "DROP TRIGGER refuse");
  ASSERT_OK(reg.Register(Truck(2, 5.0), Textures()));
  EXPECT_EQ(Query("SELECT count(*), count(t_end) FROM kp_connector"), "2|1");
}

}  // namespace
}  // namespace kawara::gis
