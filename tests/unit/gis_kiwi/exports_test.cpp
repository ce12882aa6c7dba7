#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>

#include "fixture.hpp"
#include "gis/kiwi/kiwi_csv.hpp"
#include "gis/kiwi/object_exports.hpp"
#include "gis/model/model_writers.hpp"
#include "tests/support/box_world.hpp"
#include "tests/support/painted_box.hpp"
#include "tests/support/test_doughnut.hpp"
#include "vision/sides/side_texture.hpp"

namespace kawara::gis {
namespace {

using namespace testing;
using ::testing::HasSubstr;
using ::testing::Not;

SurveyObjects Survey() {
  SurveyObjects survey{.origin = kOrigin,
                       .survey = "20261122T120000Z",
                       .objects = {Truck()},
                       .stations = {Station(0.5, 3.2, 1.0)},
                       .textures = {{"truck-1", Textures()}}};
  core::ChangedObject rubble = Gone(Truck(), 90.0);
  rubble.uid = "rubble.2";
  rubble.size_class = core::SizeClass::kRubble;
  rubble.box = {.centre_m = {-55.5, 12.25, 0.4}, .size_m = {1.2, 0.9, 0.8}, .heading_rad = -2.2};
  survey.objects.push_back(rubble);
  return survey;
}

class Exports : public ::testing::Test {
 protected:
  /// Runs a Python program with the file as its argument; it prints eight "lon lat h" an object.
  void ExpectApexes(const std::filesystem::path& file, const std::string& python) {
    { std::ofstream(folder_ / "read.py") << python; }
    std::istringstream text(Shell("/usr/bin/python3 -B '" + (folder_ / "read.py").string() + "' '" +
                                  file.string() + "'"));
    const core::LocalEnu map(kOrigin);
    for (const core::ChangedObject& object : survey_.objects) {
      for (const Eigen::Vector3d& apex : object.box.Apexes()) {
        double lon = 0, lat = 0, h = 0;
        ASSERT_TRUE(text >> lon >> lat >> h) << text.str();
        const Eigen::Vector3d read =
            map.FromGeodetic({lat * core::kRadFromDeg, lon * core::kRadFromDeg, h});
        EXPECT_LT((read - apex).norm(), 1e-3) << object.uid;
      }
    }
    std::string more;
    EXPECT_FALSE(text >> more);
  }
  std::string Text(const std::string& name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  SurveyObjects survey_ = Survey();
  TestFolder folder_;
};

TEST_F(Exports, GeoJsonHoldsTheApexes) {
  ASSERT_OK(WriteObjectsGeoJson(folder_ / "o.geojson", survey_));
  ExpectApexes(folder_ / "o.geojson", R"py(
import json, sys
for f in json.load(open(sys.argv[1]))["features"]:
    for a in f["properties"].get("apexes", []):
        print(*a)
)py");
}

// RFC 7946, 3.1.6: outer rings counter-clockwise.
TEST_F(Exports, GeoJsonIsReadByOgrAndTurnsTheRightWay) {
  ASSERT_OK(WriteObjectsGeoJson(folder_ / "o.geojson", survey_));
  const std::string path = (folder_ / "o.geojson").string();
  EXPECT_THAT(Shell("ogrinfo -ro -so '" + path + "' o"), HasSubstr("Feature Count: 3"));
  EXPECT_EQ(Shell("/usr/bin/python3 -B -c \"\nimport json\nfor f in "
                  "json.load(open('" +
                  path +
                  "'))['features']:\n  if f['geometry']['type'] != 'Polygon': continue\n  r = "
                  "f['geometry']['coordinates'][0]\n  print(r[0] == r[-1], "
                  "sum(a[0] * b[1] - a[1] * b[0] for a, b in zip([[p[0] - r[0][0], p[1] - r[0][1]] "
                  "for p in r], [[p[0] - r[0][0], p[1] - r[0][1]] for p in r[1:]])) > 0)\""),
            "True True\nTrue True\n");
}

TEST_F(Exports, GeoJsonSaysWhatARowSays) {
  ASSERT_OK(WriteObjectsGeoJson(folder_ / "o.geojson", survey_));
  const std::string json = Text("o.geojson");
  for (const char* said :
       {R"("id":"truck-1")", R"("class":"truck")", R"("t_begin":"2026-11-22T12:00:00.123Z")",
        R"("t_end":null)", R"("t_end":"2026-11-22T12:01:30.123Z")", R"("width_m":2.21)",
        R"("robot":"rover-1,rover 2")", R"("passable_width_m":3.2)",
        R"("sides_seen":"front left top")"})
    EXPECT_THAT(json, HasSubstr(said));
}

TEST_F(Exports, KmzHoldsTheApexesAndThePictures) {
  ASSERT_OK(WriteObjectsKmz(folder_ / "o.kmz", survey_));
  ExpectApexes(folder_ / "o.kmz", R"py(
import sys, xml.etree.ElementTree as E, zipfile
z = zipfile.ZipFile(sys.argv[1])
assert z.testzip() is None
assert z.namelist() == ["doc.kml", "textures/truck-1.jpg"], z.namelist()
n = "{http://www.opengis.net/kml/2.2}"
for d in E.fromstring(z.read("doc.kml")).iter(n + "Data"):
    if d.get("name") == "apexes":
        for a in d.find(n + "value").text.split():
            print(*a.split(","))
)py");
}

TEST_F(Exports, KmzIsReadWithItsTimesAndHeights) {
  ASSERT_OK(WriteObjectsKmz(folder_ / "o.kmz", survey_));
  const std::string path = (folder_ / "o.kmz").string();
  Shell("/usr/bin/python3 -m zipfile -e '" + path + "' '" + (folder_ / "x").string() + "'");
  Shell("xmllint --noout '" + (folder_ / "x/doc.kml").string() + "'");
  const std::string info = Shell("ogrinfo -ro -al '" + path + "' 'Changed objects'");
  for (const char* said :
       {"begin (DateTime) = 2026/11/22 12:00:00.123+00", "end (DateTime) = 2026/11/22 12:01:30.123",
        "altitudeMode (String) = relativeToGround", "extrude (Integer) = 1", "POLYGON Z"})
    EXPECT_THAT(info, HasSubstr(said));
}

TEST_F(Exports, CityJsonHoldsTheApexes) {
  ASSERT_OK(WriteObjectsCityJson(folder_ / "o.city.json", survey_));
  ExpectApexes(folder_ / "o.city.json", R"py(
import json, sys
from osgeo import osr
d = json.load(open(sys.argv[1]))
assert (d["type"], d["version"]) == ("CityJSON", "1.1")
utm, wgs = osr.SpatialReference(), osr.SpatialReference()
utm.ImportFromEPSG(int(d["metadata"]["referenceSystem"].rsplit("/", 1)[1]))
wgs.ImportFromEPSG(4326)
for s in utm, wgs: s.SetAxisMappingStrategy(osr.OAMS_TRADITIONAL_GIS_ORDER)
back = osr.CoordinateTransformation(utm, wgs)
s, t = d["transform"]["scale"], d["transform"]["translate"]
for v in d["vertices"]:
    assert all(isinstance(c, int) for c in v)
    print(*("%.12f" % c for c in back.TransformPoint(*(v[i] * s[i] + t[i] for i in range(3)))))
)py");
}

// The volume by the divergence theorem has a sign: every face turns outwards, and none is missing.
TEST_F(Exports, CityJsonSolidsAreClosedAndTurnOutwards) {
  ASSERT_OK(WriteObjectsCityJson(folder_ / "o.city.json", survey_));
  {
    std::ofstream(folder_ / "volume.py") << R"py(
import json, sys
import numpy as np
d = json.load(open(sys.argv[1]))
s = np.array(d["transform"]["scale"])
for name, o in d["CityObjects"].items():
    assert o["type"] == "GenericCityObject" and o["geometry"][0]["type"] == "Solid"
    volume, edges = 0.0, set()
    for (face,) in o["geometry"][0]["boundaries"][0]:
        p = [np.array(d["vertices"][i]) * s for i in face]
        for a, b in ((1, 2), (2, 3)):
            volume += np.dot(p[0], np.cross(p[a], p[b])) / 6
        for a, b in zip(face, face[1:] + face[:1]):
            assert (a, b) not in edges
            edges.add((a, b))
    assert all((b, a) in edges for a, b in edges)
    print(name, round(volume, 1))
)py";
  }
  // 7.99 x 2.21 x 3.24 and 1.2 x 0.9 x 0.8 m.
  EXPECT_EQ(Shell("/usr/bin/python3 -B '" + (folder_ / "volume.py").string() + "' '" +
                  (folder_ / "o.city.json").string() + "'"),
            "truck-1 57.2\nrubble.2 0.9\n");
}

TEST_F(Exports, CursorOnTargetEventsHoldTheApexes) {
  const std::filesystem::path path = folder_ / "events.xml";
  {
    std::ofstream file(path);
    file << "<events>";
    for (const core::ChangedObject& object : survey_.objects) {
      std::string event = CursorOnTargetEvent(object, kOrigin, At(3), At(3600));
      file << event.substr(event.find('\n'));  // the list is one document
    }
    file << "</events>";
  }
  ExpectApexes(path, R"py(
import sys, xml.etree.ElementTree as E
for a in E.parse(sys.argv[1]).iter("apex"):
    print(a.get("lon"), a.get("lat"), a.get("hae"))
)py");
}

TEST_F(Exports, CursorOnTargetEventsAreWholeAndGoStale) {
  core::ChangedObject o = Truck();
  o.robots = {"<rover> & \"co\""};
  { std::ofstream(folder_ / "e.xml") << CursorOnTargetEvent(o, kOrigin, At(3), At(3600)); }
  Shell("xmllint --noout '" + (folder_ / "e.xml").string() + "'");
  const std::string event = Text("e.xml");
  for (const char* said : {R"(version="2.0" uid="truck-1" type="b-m-p-s-m" how="m-f")",
                           R"(time="2026-11-22T12:00:03.123Z" start="2026-11-22T12:00:00.123Z")",
                           R"(stale="2026-11-22T13:00:00.123Z")", R"(ce="0.071" le="0.1")"})
    EXPECT_THAT(event, HasSubstr(said));
  EXPECT_THAT(CursorOnTargetEvent(Gone(Truck(), 90), kOrigin, At(100), At(3600)),
              HasSubstr(R"(stale="2026-11-22T12:01:30.123Z")"));
}

TEST_F(Exports, BoxMeshesAreWholeAndLookOutwards) {
  const auto meshes = BoxMeshes(survey_);
  ASSERT_EQ(meshes.size(), 3U);  // pictured and plain sides of the truck, the rubble
  EXPECT_EQ(meshes[0].triangles.size() + meshes[1].triangles.size(), 10U);
  EXPECT_EQ(meshes[2].triangles.size(), 10U);
  for (const core::TexturedMesh& mesh : meshes) {
    ASSERT_OK(CheckMesh(mesh));
    for (const auto& triangle : mesh.triangles) {
      std::array<Eigen::Vector3d, 3> p;
      for (std::size_t i = 0; i < 3; ++i) {
        const auto& q = mesh.positions_m[triangle[i]];
        p[i] = Eigen::Map<const Eigen::Vector3f>(q.data()).cast<double>();
      }
      const Eigen::Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]);
      EXPECT_GT(normal.dot(p[0]), 0.0);  // from the box's middle
      const auto& said = mesh.normals[triangle[0]];
      EXPECT_NEAR(
          normal.normalized().dot(Eigen::Map<const Eigen::Vector3f>(said.data()).cast<double>()),
          1.0, 1e-5);
    }
  }
}

// Upper left as one looks at it: over the right edge of the front, under the picture's origin.
TEST_F(Exports, BoxMeshesHangThePicturesTheRightWay) {
  const auto meshes = BoxMeshes(survey_);
  const auto apexes = survey_.objects[0].box.Apexes();
  // Side "left": from the front left edge (apexes 0 and 4) to the rear left one (1 and 5).
  const std::array<std::size_t, 4> expected{4, 5, 1, 0};
  const auto& coordinates = meshes[0].texture_coordinates;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& q = meshes[0].positions_m[i];
    const Eigen::Vector3d corner =
        Eigen::Map<const Eigen::Vector3f>(q.data()).cast<double>() + meshes[0].offset_m;
    EXPECT_LT((corner - apexes[expected[i]]).norm(), 1e-5);
  }
  EXPECT_FLOAT_EQ(coordinates[2][0], 40.0F / 64.0F);
  EXPECT_FLOAT_EQ(coordinates[2][1], 20.0F / 48.0F);
}

TEST_F(Exports, BoxMeshesBecomeVrmlAndGlb) {
  const auto meshes = BoxMeshes(survey_);
  ASSERT_OK(WriteVrml(folder_ / "o.wrl", meshes, kOrigin));
  ASSERT_OK(WriteGlb(folder_ / "o.glb", meshes, kOrigin));
  EXPECT_THAT(Text("o.wrl"), HasSubstr("DEF object0_truck-1 Transform"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "object0_truck-1_r1.jpg"));
}

/// The truck as pictures of its paint show it.
core::ObjectTextures Photographed(const core::ChangedObject& truck) {
  kawara::testing::PaintedBox world;
  world.box = truck.box;
  const auto camera = *vision::DoughnutCamera::Create(vision::TestDoughnut(512));
  std::vector<kawara::testing::PaintedView> looks;
  for (const double ahead_m : {-6.0, 0.0, 6.0}) {
    Eigen::Vector3d at(0, 0, 1.8);
    at.head<2>() = truck.box.centre_m.head<2>() + ahead_m * truck.box.Forward() +
                   (ahead_m == 0.0 ? 4.0 : 1.0) * truck.box.Left();
    looks.push_back(world.LookAt(camera, kawara::testing::UprightCamera(at, 0.0)));
  }
  std::vector<vision::SideView> views;
  for (std::size_t i = 0; i < looks.size(); ++i)
    views.push_back({.view = {.camera = camera,
                              .picture = looks[i].picture(),
                              .ranges = &looks[i].ranges,
                              .map_from_camera = looks[i].map_from_camera},
                     .source = "m1/" + std::to_string(i),
                     .taken = At(static_cast<double>(i))});
  vision::JpegEncoder encoder;
  auto textures = vision::MakeSideTextures(truck, views, {}, encoder);
  if (!textures) throw std::runtime_error(textures.error().message);
  return *textures;
}

TEST_F(Exports, SidesThatPicturesShowGoIntoTheRegisterAndEveryExport) {
  const core::ChangedObject truck = Truck();
  const core::ObjectTextures textures = Photographed(truck);
  ASSERT_EQ(textures.faces.size(), 2U);  // front and left; the top is above the camera
  auto reg = OpenRegister(folder_ / "mission.gpkg");
  ASSERT_OK(reg.Register(truck, textures));
  EXPECT_EQ(Sql(folder_ / "mission.gpkg",
                "SELECT face, source, seen_share > 0.9, taken FROM kp_texture ORDER BY face"),
            "front|m1/2|1|2026-11-22T12:00:02.123Z\nleft|m1/1|1|2026-11-22T12:00:01.123Z");
  const auto same_picture = [&](const std::string& name) {
    const std::string text = Text(name);
    return std::equal(text.begin(), text.end(), textures.atlas_jpeg.begin(),
                      textures.atlas_jpeg.end(),
                      [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
  };
  EXPECT_TRUE(same_picture("textures/truck-1/truck-1_r1.jpg"));
  survey_.objects = {truck};
  survey_.textures = {{truck.uid, textures}};
  const auto meshes = BoxMeshes(survey_);
  ASSERT_EQ(meshes.size(), 2U);  // pictured and plain
  ASSERT_OK(WriteVrml(folder_ / "o.wrl", meshes, kOrigin));
  EXPECT_TRUE(same_picture("object0_truck-1_r1.jpg"));
  const std::string jpeg(textures.atlas_jpeg.begin(), textures.atlas_jpeg.end());
  ASSERT_OK(WriteGlb(folder_ / "o.glb", meshes, kOrigin));
  EXPECT_NE(Text("o.glb").find(jpeg), std::string::npos);
  ASSERT_OK(WriteObjectsKmz(folder_ / "o.kmz", survey_));
  {
    std::ofstream(folder_ / "take.py") << R"(import sys, zipfile
sys.stdout.buffer.write(zipfile.ZipFile(sys.argv[1]).read("textures/truck-1.jpg")))";
  }
  EXPECT_EQ(Shell("/usr/bin/python3 -B '" + (folder_ / "take.py").string() + "' '" +
                  (folder_ / "o.kmz").string() + "'"),
            jpeg);
}

TEST_F(Exports, TheSameObjectsGiveTheSameBytes) {
  for (const char* name : {"a", "b"}) {
    const std::string n = name;
    ASSERT_OK(WriteObjectsGeoJson(folder_ / (n + ".geojson"), survey_));
    ASSERT_OK(WriteObjectsKmz(folder_ / (n + ".kmz"), survey_));
    ASSERT_OK(WriteObjectsCityJson(folder_ / (n + ".city.json"), survey_));
  }
  for (const char* suffix : {".geojson", ".kmz", ".city.json"})
    EXPECT_EQ(Text(std::string("a") + suffix), Text(std::string("b") + suffix));
}

TEST_F(Exports, NothingFoundIsAFileToo) {
  const SurveyObjects nothing{.origin = kOrigin, .survey = "empty"};
  ASSERT_OK(WriteObjectsGeoJson(folder_ / "n.geojson", nothing));
  ASSERT_OK(WriteObjectsKmz(folder_ / "n.kmz", nothing));
  ASSERT_OK(WriteObjectsCityJson(folder_ / "n.city.json", nothing));
  EXPECT_TRUE(BoxMeshes(nothing).empty());
  Shell("/usr/bin/python3 -c \"import json; json.load(open('" + (folder_ / "n.geojson").string() +
        "')); json.load(open('" + (folder_ / "n.city.json").string() + "'))\"");
}

TEST_F(Exports, CityJsonEndsAtThePoles) {
  survey_.origin = {1.55, 0.3, 0.0};
  const auto written = WriteObjectsCityJson(folder_ / "o.city.json", survey_);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, core::ErrorCode::kInvalidArgument);
}

TEST_F(Exports, TheCsvTwinSaysWhatTheTablesSay) {
  const std::filesystem::path store = folder_ / "changes.gpkg";
  {
    auto reg = OpenRegister(store);
    ASSERT_OK(reg.Register(Truck(1)));
    ASSERT_OK(reg.Register(Truck(2, 5.0)));
    ASSERT_OK(reg.RegisterStations(survey_.stations, At(9)));
  }
  KiwiCsv csv(folder_.path());
  ASSERT_OK(ReplayKiwiPlus(store.string(), csv));
  ASSERT_OK(csv.Finish());
  const auto rows = [this](const std::string& name, const std::string& columns) {
    return Shell("/usr/bin/python3 -B -c \"\nimport csv\nfor r in csv.DictReader(open('" +
                 (folder_ / name).string() +
                 "', newline='', encoding='utf-8')):\n  print('|'.join("
                 "r[c] for c in '" +
                 columns + "'.split()))\"");
  };
  EXPECT_EQ(rows("vector.csv", "id class_code flags t_begin t_end"),
            Sql(store, "SELECT id,class_code,flags,t_begin,t_end FROM kp_vector") + "\n");
  EXPECT_EQ(
      rows("connector.csv", "id class_code flags t_begin t_end object_uid"),
      Sql(store, "SELECT id,class_code,flags,t_begin,t_end,object_uid FROM kp_connector") + "\n");
  EXPECT_EQ(rows("attribute.csv", "connector_id key value unit"),
            Sql(store, "SELECT connector_id,key,value,unit FROM kp_attribute") + "\n");
  EXPECT_EQ(rows("feature_space.csv", "class_code name dim parent"),
            Sql(store, "SELECT class_code,name,dim,parent FROM kp_feature_space") + "\n");
  EXPECT_THAT(Text("vector.csv"), HasSubstr("\"LINESTRING (139.70"));
  EXPECT_THAT(Text("connector.csv"), HasSubstr("POINT (139.70"));
}

TEST_F(Exports, TheCsvTwinNeedsARegister) {
  KiwiCsv csv(folder_.path());
  EXPECT_FALSE(ReplayKiwiPlus((folder_ / "none.gpkg").string(), csv));
  EXPECT_FALSE(csv.Close(ElementKind::kVector, "nobody", At(1)));
}

}  // namespace
}  // namespace kawara::gis
