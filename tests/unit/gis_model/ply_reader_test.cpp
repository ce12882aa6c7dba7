#include "gis/model/ply_reader.hpp"

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <iterator>
#include <limits>

#include "gis/model/model_writers.hpp"
#include "tests/support/test_folder.hpp"

namespace kawara::gis {
namespace {

using core::ErrorCode;
using testing::TestFolder;

const core::Geodetic kOrigin{35.7 * core::kRadFromDeg, 139.7 * core::kRadFromDeg, 41.25};

core::TexturedMesh Triangle() {
  core::TexturedMesh mesh;
  mesh.name = "tile_0_0";
  mesh.offset_m = {64000.0, -12.8, 3.0};
  mesh.positions_m = {{0, 0, 0}, {2, 0, 0}, {2, 3, 0.5F}};
  mesh.normals.assign(3, {0, 0, 1});
  mesh.colours = {{255, 0, 1}, {0, 255, 2}, {188, 7, 255}};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

class PlyReader : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(WritePlyMesh(path_, std::array{Triangle()}, kOrigin));
    std::ifstream file(path_, std::ios::binary);
    whole_ = {std::istreambuf_iterator<char>(file), {}};
  }
  core::Expected<std::vector<core::ColouredPoint>> Read(const std::string& bytes) const {
    std::ofstream(path_, std::ios::binary) << bytes;
    return ReadPlyPoints(path_);
  }
  std::string With(const std::string& part, const std::string& instead) const {
    std::string text = whole_;
    return text.replace(text.find(part), part.size(), instead);
  }
  TestFolder folder_;
  std::filesystem::path path_ = folder_ / "m.ply";
  std::string whole_;
};

TEST_F(PlyReader, CornersComeBackAsTheyWereWritten) {
  const auto points = ReadPlyPoints(path_);
  ASSERT_TRUE(points) << points.error().message;
  const core::TexturedMesh mesh = Triangle();
  ASSERT_EQ(points->size(), mesh.positions_m.size());
  for (std::size_t i = 0; i < points->size(); ++i) {
    EXPECT_EQ((*points)[i].colour, mesh.colours[i]);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      EXPECT_DOUBLE_EQ((*points)[i].position_m[axis],
                       mesh.offset_m[axis] + static_cast<double>(mesh.positions_m[i][k]));
    }
  }
}

TEST_F(PlyReader, OthersFloatsAndNumbersAreRead) {
  std::string file =
      "ply\r\nformat binary_little_endian 1.0\r\ncomment theirs\r\nelement vertex 1\r\n"
      "property uint8 red\r\nproperty uint8 green\r\nproperty uint8 blue\r\nproperty short "
      "votes\r\n"
      "property float32 x\r\nproperty float32 y\r\nproperty float32 z\r\nend_header\r\n";
  file += "\x0A\x14\x1E";
  file += "zz";
  for (const float value : {1.5F, -2.25F, 1e4F}) {
    file.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  const auto points = Read(file);
  ASSERT_TRUE(points) << points.error().message;
  ASSERT_EQ(points->size(), 1U);
  EXPECT_EQ((*points)[0].position_m, Eigen::Vector3d(1.5, -2.25, 1e4));
  EXPECT_EQ((*points)[0].colour, (std::array<std::uint8_t, 3>{10, 20, 30}));
}

TEST_F(PlyReader, WhatEndsBeforeItsCornersIsRefused) {
  const std::size_t corners = whole_.find("end_header\n") + 11;
  for (const std::size_t size : {std::size_t{0}, std::size_t{3}, std::size_t{40}, corners - 1,
                                 corners, corners + 3 * 39 - 1}) {
    const auto points = Read(whole_.substr(0, size));
    ASSERT_FALSE(points) << size;
    EXPECT_EQ(points.error().code, ErrorCode::kFormat);
    EXPECT_NE(points.error().message.find("m.ply"), std::string::npos);
  }
  EXPECT_TRUE(Read(whole_.substr(0, corners + 3 * 39))) << "what follows is not wanted";
}

TEST_F(PlyReader, OtherFilesAreRefused) {
  for (const auto& [part, instead] : std::initializer_list<std::pair<std::string, std::string>>{
           {"ply", "plx"},
           {"binary_little_endian", "ascii"},
           {"element vertex 3", "element vertex -3"},
           {"element vertex 3", "element vertex 18446744073709551615"},
           {"element vertex 3", "element vertex 3 4"},
           {"element vertex", "element edge"},
           {"property double x", "property double w"},
           {"property double x", "property quad x"},
           {"property double x", "property list uchar int x"},
           {"property double x", "property int x"},
           {"property uchar red", "property float red"}}) {
    EXPECT_FALSE(Read(With(part, instead))) << instead;
  }
}

TEST_F(PlyReader, AFileThatIsNotThereIsNotFound) {
  const auto points = ReadPlyPoints(folder_ / "none.ply");
  ASSERT_FALSE(points);
  EXPECT_EQ(points.error().code, ErrorCode::kNotFound);
}

TEST_F(PlyReader, AFolderIsAnError) { EXPECT_FALSE(ReadPlyPoints(folder_.path())); }

}  // namespace
}  // namespace kawara::gis
