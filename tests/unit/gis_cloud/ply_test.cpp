#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "gis/model/model_writers.hpp"
#include "tests/support/test_folder.hpp"
#include "tests/unit/gis_cloud/cloud_bytes.hpp"

namespace kawara::gis {
namespace {

using Eigen::Vector3d;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::TestFolder;

std::vector<Vector3d> Positions(const WholeCloud& cloud) {
  std::vector<Vector3d> positions;
  for (const CloudPoint& p : cloud.points) positions.push_back(p.position);
  return positions;
}

/// Faces and a list before and among the vertices' properties, in any format.
std::string Awkward(const std::string& format, bool ascii, bool big) {
  std::string file = "ply\nformat " + format +
                     " 1.0\ncomment made by hand\nobj_info x 1\nelement face 2\n"
                     "property list uchar int vertex_indices\nproperty float quality\n"
                     "element vertex 2\nproperty short z\nproperty list ushort float weights\n"
                     "property double x\nproperty uchar red\nproperty uchar green\n"
                     "property uchar blue\nproperty float y\nproperty float intensity\n"
                     "element edge 1\nproperty int a\nend_header\n";
  if (ascii)
    return file +
           "3 0 1 0 0.5\n0 1\n\n-3 2 0.5 0.25 1.5 10 20 30 2.25 0.125\n+4 0 1e2 0 0 255 nan 0\n1\n";
  const auto put = [&](auto value) { big ? PutBig(file, value) : Put(file, value); };
  put(std::uint8_t{3});
  for (const std::int32_t i : {0, 1, 0}) put(i);
  put(0.5F);
  put(std::uint8_t{0});
  put(1.0F);
  put(std::int16_t{-3});
  put(std::uint16_t{2});
  put(0.5F);
  put(0.25F);
  put(1.5);
  for (const int c : {10, 20, 30}) put(static_cast<std::uint8_t>(c));
  put(2.25F);
  put(0.125F);
  put(std::int16_t{4});
  put(std::uint16_t{0});
  put(100.0);
  for (const int c : {0, 0, 255}) put(static_cast<std::uint8_t>(c));
  put(std::numeric_limits<float>::quiet_NaN());
  put(0.0F);
  put(std::int32_t{1});
  return file;
}

TEST(Ply, EveryFormatGivesTheSame) {
  const TestFolder folder;
  for (const auto& [format, ascii, big] : {std::tuple{"ascii", true, false},
                                           {"binary_little_endian", false, false},
                                           {"binary_big_endian", false, true}}) {
    const auto all = ReadAll(WriteTo(folder / "a.ply", Awkward(format, ascii, big)));
    ASSERT_TRUE(all.info) << format << all.info.error().message;
    ASSERT_EQ(all.points.size(), 1U) << format;
    EXPECT_EQ(all.points[0].position, Vector3d(1.5, 2.25, -3)) << format;
    EXPECT_THAT(all.points[0].colour, ElementsAre(10, 20, 30)) << format;
    EXPECT_EQ(all.points[0].intensity, 0.125F) << format;
    EXPECT_EQ(all.info->promised, 2U);
    EXPECT_EQ(all.info->delivered, 1U);
    EXPECT_EQ(all.info->not_finite, 1U);
    EXPECT_TRUE(all.info->has_colour && all.info->has_intensity && !all.info->has_time);
    EXPECT_THAT(all.info->comments, ElementsAre("made by hand", "x 1"));
  }
}

TEST(Ply, AnyBufferAndChunkGivesTheSame) {
  const TestFolder folder;
  for (const char* format : {"ascii", "binary_big_endian"}) {
    const std::string path =
        WriteTo(folder / "a.ply", Awkward(format, format[0] == 'a', format[0] == 'b'));
    for (const std::size_t buffer : {1U, 2U, 7U, 64U, 4096U})
      for (const std::size_t chunk : {1U, 2U, 100U}) {
        const auto all = ReadAll(path, {chunk, buffer});
        ASSERT_TRUE(all.info) << all.info.error().message;
        EXPECT_THAT(Positions(all), ElementsAre(Vector3d(1.5, 2.25, -3)));
      }
  }
}

TEST(Ply, EveryNumberType) {
  const TestFolder folder;
  std::string file =
      "ply\r\nformat binary_little_endian 1.0\r\nelement vertex 1\r\nproperty int8 x\r\n"
      "property uint16 y\r\nproperty int32 z\r\nproperty uint32 a\r\nproperty uint8 b\r\n"
      "property float64 time\r\nend_header\r\n";
  Put(file, std::int8_t{-5});
  Put(file, std::uint16_t{65000});
  Put(file, std::int32_t{-70000});
  Put(file, std::uint32_t{1});
  Put(file, std::uint8_t{1});
  Put(file, 0.5);
  const auto all = ReadAll(WriteTo(folder / "a.ply", file));
  ASSERT_TRUE(all.info) << all.info.error().message;
  EXPECT_THAT(Positions(all), ElementsAre(Vector3d(-5, 65000, -70000)));
  EXPECT_EQ(all.points[0].time_s, 0.5);
}

TEST(Ply, OurOwnMeshComesBackWithItsOrigin) {
  const TestFolder folder;
  core::TexturedMesh mesh;
  mesh.name = "m";
  mesh.offset_m = {10'000.125, -3, 0};
  mesh.positions_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5F}};
  mesh.colours = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  mesh.triangles = {{0, 1, 2}};
  const core::Geodetic origin{35.123456789 * core::kRadFromDeg, -139.5 * core::kRadFromDeg, -41.25};
  ASSERT_TRUE(WritePlyMesh(folder / "m.ply", std::array{mesh}, origin));
  const auto all = ReadAll((folder / "m.ply").string());
  ASSERT_TRUE(all.info) << all.info.error().message;
  ASSERT_TRUE(all.info->origin);
  EXPECT_NEAR(all.info->origin->lat_rad, origin.lat_rad, 1e-11);
  EXPECT_NEAR(all.info->origin->lon_rad, origin.lon_rad, 1e-11);
  EXPECT_EQ(all.info->origin->h_ellipsoidal_m, -41.25);
  EXPECT_THAT(Positions(all), ElementsAre(Vector3d(10'000.125, -3, 0), Vector3d(10'001.125, -3, 0),
                                          Vector3d(10'000.125, -2, 0.5)));
  EXPECT_THAT(all.points[1].colour, ElementsAre(4, 5, 6));
}

TEST(Ply, ItsOwnOriginIsMovedToTheMaps) {
  const TestFolder folder;
  const core::Geodetic file_origin{0.62, 2.43, 40.0}, map{0.6201, 2.4301, 35.0};
  core::TexturedMesh mesh;
  mesh.name = "m";
  mesh.positions_m = {{0, 0, 0}, {100, 0, 3}, {0, 50, 0}};
  mesh.triangles = {{0, 1, 2}};
  ASSERT_TRUE(WritePlyMesh(folder / "m.ply", std::array{mesh}, file_origin));
  const std::string path = (folder / "m.ply").string();
  const auto moved = ReadAllEnu(path, {map});
  ASSERT_TRUE(moved.info) << moved.info.error().message;
  const core::Geodetic there = core::LocalEnu(file_origin).ToGeodetic({100, 0, 3});
  EXPECT_LT((moved.points[1].position - core::LocalEnu(map).FromGeodetic(there)).norm(), 1e-4);
  EXPECT_EQ(moved.info->heights, HeightDatum::kEllipsoidal);
  const auto same = ReadAllEnu(path, {map, Coordinates::kLocalMetres});
  EXPECT_EQ(same.points[1].position, Vector3d(100, 0, 3));
}

TEST(Ply, WithoutOriginItMustBeSaidToBeLocal) {
  const TestFolder folder;
  const std::string path = WriteTo(
      folder / "a.ply",
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty "
      "float z\nend_header\n1 2 3");
  const auto refused = ReadAllEnu(path, {});
  ASSERT_FALSE(refused.info);
  EXPECT_EQ(refused.info.error().code, core::ErrorCode::kInvalidArgument);
  EXPECT_THAT(refused.info.error().message, HasSubstr("local metres"));
  EXPECT_TRUE(refused.points.empty());
  EXPECT_EQ(ReadAllEnu(path, {{}, Coordinates::kLocalMetres}).points.at(0).position,
            Vector3d(1, 2, 3));
}

TEST(Ply, CutOffAnywhereTheWholePointsCome) {
  const TestFolder folder;
  std::string file =
      "ply\nformat binary_little_endian 1.0\nelement vertex 5\nproperty float x\nproperty float "
      "y\nproperty float z\nend_header\n";
  const std::size_t body = file.size();
  for (int i = 0; i < 15; ++i) Put(file, static_cast<float>(i));
  for (std::size_t size = body; size < file.size(); ++size) {
    const auto all = ReadAll(WriteTo(folder / "cut.ply", file.substr(0, size)), {2, 16});
    const std::size_t whole = (size - body) / 12;
    ASSERT_FALSE(all.info);
    EXPECT_EQ(all.points.size(), whole);
    EXPECT_THAT(all.info.error().message,
                HasSubstr("ends after " + std::to_string(whole) + " of 5 points, at byte " +
                          std::to_string(size)));
  }
  for (std::size_t size = 0; size < body; ++size) {
    const auto all = ReadAll(WriteTo(folder / "cut.ply", file.substr(0, size)));
    ASSERT_FALSE(all.info);
    EXPECT_EQ(all.info.error().code, core::ErrorCode::kFormat) << size;
  }
}

TEST(Ply, FaultsAreSaidWithTheirPlace) {
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::pair<std::string, const char*> cases[] = {
      {"", "is empty"},
      {"hello\n", "neither a PLY nor a LAS"},
      {"plywood\n", "no PLY file"},
      {"ply\nformat ascii 1.0\n", "its header has no end"},
      {"ply\nformat middle_endian 1.0\n", "line 2: an unknown format, middle_endian"},
      {"ply\nelement vertex 0\n" + xyz + "end_header\n", "states no format"},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n", "no x, y, z"},
      {"ply\nformat ascii 1.0\nend_header\n", "no element vertex"},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty word x\n",
       "line 4: a property of type word"},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty list float int x\n",
       "line 4: a list counted in float"},
      {"ply\nformat ascii 1.0\nelement vertex 99999999999999999999\nend_header\n", "how many"},
      {"ply\nformat ascii 1.0\nelement vertex -1\nend_header\n", "how many"},
      {"ply\nformat ascii 1.0\nproperty float x\n", "before any element"},
      {"ply\nformat ascii 1.0\nelement vertex 1\n" + xyz + "property float x\nend_header\n",
       "two properties x"},
      {"ply\nformat ascii 1.0\nelement vertex 2\n" + xyz + "end_header\n1 2 3\n",
       "ends after 1 of 2 points"},
      {"ply\nformat ascii 1.0\nelement vertex 2\n" + xyz + "end_header\n1 2 3\n4 5",
       "ends after 1 of 2 points"},
      {"ply\nformat ascii 1.0\nelement vertex 2\n" + xyz + "end_header\n1 2\n3 4 5\n",
       "line 8: no number for z"},
      {"ply\nformat ascii 1.0\nelement vertex 2\n" + xyz + "end_header\n1 2 3\n4 five 6\n",
       "line 9: no number for y, value 2 of the line (after 1 of 2 points)"},
      {"ply\nformat ascii 1.0\nelement vertex 2\n" + xyz + "end_header\n1 2 3 4\n4 5 6\n",
       "line 8: more values"},
  };
  const TestFolder folder;
  for (const auto& [text, message] : cases) {
    const auto all = ReadAll(WriteTo(folder / "bad.ply", text));
    ASSERT_FALSE(all.info) << text;
    EXPECT_EQ(all.info.error().code, core::ErrorCode::kFormat) << text;
    EXPECT_THAT(all.info.error().message, HasSubstr(message));
  }
}

TEST(Ply, MissingFilesAndFolders) {
  const TestFolder folder;
  const auto none = ReadCloudInfo((folder / "none.ply").string());
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, core::ErrorCode::kNotFound);
  EXPECT_FALSE(ReadCloudInfo(folder.path().string()));
}

}  // namespace
}  // namespace kawara::gis
