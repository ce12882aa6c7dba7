#include "gis/model/model_writers.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>

#include "tests/support/test_folder.hpp"

namespace kawara::gis {
namespace {

using testing::TestFolder;

const core::Geodetic kOrigin{35.7 * core::kRadFromDeg, 139.7 * core::kRadFromDeg, 41.25};

core::TexturedMesh Square() {
  core::TexturedMesh mesh;
  mesh.name = "tile_1_-2";
  mesh.revision = 7;
  mesh.offset_m = {6.4, -12.8, 0.0};
  mesh.positions_m = {{0, 0, 0}, {2, 0, 0}, {2, 3, 0.5F}, {0, 3, 0.5F}};
  mesh.normals.assign(4, {0, 0, 1});
  mesh.colours = {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {188, 188, 188}};
  mesh.texture_coordinates = {{0, 0}, {1, 0}, {1, 0.25F}, {0, 0.25F}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.texture_jpeg = {0xFF, 0xD8, 0xFF, 0xD9};
  return mesh;
}

std::string TextOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

template <class T>
T At(const std::string& bytes, std::size_t offset) {
  T value{};
  EXPECT_LE(offset + sizeof(T), bytes.size());
  if (offset + sizeof(T) <= bytes.size()) std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

bool Has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(ModelWriters, VrmlHoldsShapeTextureAndOrigin) {
  TestFolder folder;
  ASSERT_TRUE(WriteVrml(folder / "m.wrl", std::array{Square()}, kOrigin));
  const std::string text = TextOf(folder / "m.wrl");
  EXPECT_TRUE(text.starts_with("#VRML V2.0 utf8\n"));
  EXPECT_TRUE(Has(text, "latitude 35.7 deg, longitude 139.7 deg, ellipsoidal height 41.25 m"));
  EXPECT_TRUE(Has(text, "tile_1_-2 revision 7"));
  EXPECT_TRUE(Has(text, "translation 6.4 -12.8 0"));
  EXPECT_TRUE(Has(text, "2 3 0.5,"));
  EXPECT_TRUE(Has(text, "0,2,3,-1,"));
  EXPECT_TRUE(Has(text, "1 0.75,"));  // counted from the lower edge
  EXPECT_TRUE(Has(text, "ImageTexture { url \"tile_1_-2_r7.jpg\" }"));
  EXPECT_EQ(TextOf(folder / "tile_1_-2_r7.jpg").size(), 4U);
}

TEST(ModelWriters, GlbIsWellFormedAndExact) {
  TestFolder folder;
  auto plain = Square();
  plain.name = "plain";
  plain.texture_jpeg.clear();
  plain.texture_coordinates.clear();
  ASSERT_TRUE(WriteGlb(folder / "m.glb", std::array{Square(), plain}, kOrigin));
  const std::string glb = TextOf(folder / "m.glb");
  EXPECT_EQ(glb.substr(0, 4), "glTF");
  EXPECT_EQ(At<std::uint32_t>(glb, 4), 2U);
  EXPECT_EQ(At<std::uint32_t>(glb, 8), glb.size());
  const auto json_bytes = At<std::uint32_t>(glb, 12);
  ASSERT_EQ(json_bytes % 4, 0U);
  const std::string json = glb.substr(20, json_bytes);
  EXPECT_TRUE(Has(json, "\"min\":[0,0,0],\"max\":[2,3,0.5]"));
  EXPECT_TRUE(Has(json, "\"translation\":[6.4,-12.8,0]"));
  EXPECT_TRUE(Has(json, "\"COLOR_0\""));
  EXPECT_TRUE(Has(json, "\"extras\":{\"revision\":7}"));
  const std::size_t binary = 20 + json_bytes + 8;
  EXPECT_EQ(At<std::uint32_t>(glb, 20 + json_bytes), glb.size() - binary);
  EXPECT_EQ(At<float>(glb, binary + 12), 2.0F);  // the second corner's x
}

TEST(ModelWriters, GlbOfNothingIsAFileStill) {
  TestFolder folder;
  ASSERT_TRUE(WriteGlb(folder / "m.glb", {}, kOrigin));
  const std::string glb = TextOf(folder / "m.glb");
  EXPECT_EQ(At<std::uint32_t>(glb, 8), glb.size());
  EXPECT_FALSE(Has(glb, "bufferViews"));  // empty lists are not allowed
}

TEST(ModelWriters, PlyCountsAndMapCoordinates) {
  TestFolder folder;
  ASSERT_TRUE(WritePlyMesh(folder / "m.ply", std::array{Square(), Square()}, kOrigin));
  const std::string ply = TextOf(folder / "m.ply");
  EXPECT_TRUE(Has(ply, "element vertex 8\n"));
  EXPECT_TRUE(Has(ply, "element face 4\n"));
  const std::size_t body = ply.find("end_header\n") + 11;
  ASSERT_EQ(ply.size() - body, 8U * 39U + 4U * 13U);
  EXPECT_DOUBLE_EQ(At<double>(ply, body + 39), 8.4);
  EXPECT_DOUBLE_EQ(At<double>(ply, body + 39 + 8), -12.8);
  EXPECT_EQ(At<std::int32_t>(ply, body + 8 * 39 + 2 * 13 + 1), 4);  // of the second mesh
}

TEST(ModelWriters, LasIsInUtmOfTheOrigin) {
  TestFolder folder;
  const std::array<core::ColouredPoint, 2> points{
      {{{0, 0, 0}, {10, 20, 255}, 9}, {{100, 0, 2}, {0, 0, 0}, 65535}}};
  ASSERT_TRUE(WriteLas(folder / "m.las", points, kOrigin));
  const std::string las = TextOf(folder / "m.las");
  EXPECT_EQ(las.substr(0, 4), "LASF");
  EXPECT_EQ(At<std::uint16_t>(las, 94), 375);
  const auto first = At<std::uint32_t>(las, 96);
  ASSERT_EQ(las.size(), first + 2 * 36U);
  EXPECT_EQ(At<std::uint64_t>(las, 247), 2U);
  EXPECT_TRUE(Has(las, "\"EPSG\",\"32654\""));
  const auto coordinate = [&](std::size_t point, std::size_t axis) {
    return At<std::int32_t>(las, first + 36 * point + 4 * axis) * At<double>(las, 131 + 8 * axis) +
           At<double>(las, 155 + 8 * axis);
  };
  // 35.7 N 139.7 E in zone 54 (EPSG:32654), from PROJ 9.1 by way of GDAL.
  EXPECT_NEAR(coordinate(0, 0), 382388.694, 0.002);
  EXPECT_NEAR(coordinate(0, 1), 3951453.574, 0.002);
  EXPECT_NEAR(coordinate(0, 2), 41.25, 0.001);
  // 100 m east: grid scale at that place, and the grid's north west of true north.
  EXPECT_NEAR(std::hypot(coordinate(1, 0) - coordinate(0, 0), coordinate(1, 1) - coordinate(0, 1)),
              100.0 * 0.99977, 0.01);
  EXPECT_DOUBLE_EQ(At<double>(las, 179), coordinate(1, 0));  // max x
  EXPECT_EQ(At<std::uint16_t>(las, first + 12), 9);
  EXPECT_EQ(At<std::uint16_t>(las, first + 34), 65535);  // blue
}

TEST(ModelWriters, TilesetStandsOnTheEllipsoid) {
  TestFolder folder;
  const TileEntry entry = EntryOf(Square(), "tiles/a.glb");
  EXPECT_NEAR(entry.max_m.y(), -9.8, 1e-6);
  ASSERT_TRUE(WriteTileset(folder / "tileset.json", std::array{entry}, kOrigin));
  const std::string json = TextOf(folder / "tileset.json");
  EXPECT_TRUE(Has(json, "\"version\":\"1.1\""));
  EXPECT_TRUE(Has(json, "\"uri\":\"tiles/a.glb\""));
  EXPECT_TRUE(Has(json, "{\"box\":[7.4,-11.3,0.25,1,0,0,0,1.5,0,0,0,0.25]}"));
  // The transform's last column is the origin, its third looks up.
  const std::size_t at = json.find("\"transform\":[") + 13;
  std::array<double, 16> m{};
  std::size_t next = at;
  for (double& v : m) {
    std::size_t used = 0;
    v = std::stod(json.substr(next), &used);
    next += used + 1;
  }
  const Eigen::Vector3d origin = core::EcefFromGeodetic(kOrigin);
  EXPECT_LT((Eigen::Vector3d(m[12], m[13], m[14]) - origin).norm(), 1e-6);
  const core::LocalEnu enu(kOrigin);
  const Eigen::Map<const Eigen::Matrix4d> matrix(m.data());
  const Eigen::Vector3d p(30, -40, 5);
  const Eigen::Vector3d ecef = (matrix * p.homogeneous()).head<3>();
  EXPECT_LT((ecef - core::EcefFromGeodetic(enu.ToGeodetic(p))).norm(), 1e-6);
}

TEST(ModelWriters, AContradictoryMeshIsRefusedAndLeavesNoFile) {
  TestFolder folder;
  using Spoil = void (*)(core::TexturedMesh&);
  const std::array<Spoil, 6> spoilers{
      [](core::TexturedMesh& m) { m.triangles[1][2] = 4; },
      [](core::TexturedMesh& m) { m.normals.pop_back(); },
      [](core::TexturedMesh& m) { m.name = "../../etc"; },
      [](core::TexturedMesh& m) { m.positions_m[0][1] = std::nanf(""); },
      [](core::TexturedMesh& m) { m.texture_coordinates.clear(); },
      [](core::TexturedMesh& m) { m.offset_m.x() = std::numeric_limits<double>::infinity(); }};
  for (const Spoil spoil : spoilers) {
    std::array meshes{Square()};
    spoil(meshes[0]);
    EXPECT_FALSE(WriteVrml(folder / "m", meshes, kOrigin));
    EXPECT_FALSE(WriteGlb(folder / "m", meshes, kOrigin));
    EXPECT_FALSE(WritePlyMesh(folder / "m", meshes, kOrigin));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  EXPECT_FALSE(WriteGlb(folder / "no" / "m.glb", std::array{Square()}, kOrigin));
}

}  // namespace
}  // namespace kawara::gis
