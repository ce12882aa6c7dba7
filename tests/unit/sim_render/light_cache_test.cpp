#include "sim/render/light_cache.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/unit/sim_render/test_scenes.hpp"

namespace kawara::sim {
namespace {

namespace fs = std::filesystem;

class LightCacheTest : public ::testing::Test {
 protected:
  LightCacheTest() {
    std::string pattern = (fs::temp_directory_path() / "kawara-light-XXXXXX").string();
    root_ = ::mkdtemp(pattern.data());
    light_.cache = root_ / "new" / "folder";
    light_.cell_m = 1.0;
    light_.max_points = 500;
    light_.sky_columns = 64;
  }
  ~LightCacheTest() override { fs::remove_all(root_); }

  std::shared_ptr<const LitScene> Make() const { return *LitScene::Create(scene_, light_); }
  std::vector<fs::path> Files() const {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(light_.cache)) files.push_back(entry.path());
    return files;
  }
  static void ExpectTheSameLight(const LitScene& a, const LitScene& b) {
    ASSERT_EQ(a.light().point_count(), b.light().point_count());
    for (double x = -9.0; x < 9.0; x += 0.7) {
      for (const Eigen::Vector3f& n : {Eigen::Vector3f(0, 0, 1), Eigen::Vector3f(0.6F, -0.8F, 0)}) {
        EXPECT_TRUE(
            (a.light().At({x, 0.3 * x, 0.2}, n) == b.light().At({x, 0.3 * x, 0.2}, n)).all());
      }
    }
  }

  fs::path root_;
  Scene scene_ = CornerScene();
  LightSettings light_;
};

TEST_F(LightCacheTest, WhatIsKeptIsTheSameLight) {
  const auto measured = Make();
  const auto kept = Make();
  EXPECT_FALSE(measured->light().from_cache());
  EXPECT_TRUE(kept->light().from_cache());
  ExpectTheSameLight(*measured, *kept);
  EXPECT_EQ(Files().size(), 1U);
}

TEST_F(LightCacheTest, AnythingThatChangesTheLightIsMeasuredAnew) {
  Make();
  const auto expect_new = [&](const char* what) {
    EXPECT_FALSE(Make()->light().from_cache()) << what;
    EXPECT_TRUE(Make()->light().from_cache()) << what;
  };
  scene_.sun.azimuth_rad += 0.01;
  expect_new("sun");
  scene_.materials[2].base_rgb[1] += 0.01F;
  expect_new("colour");
  scene_.meshes[1].vertices_m[3].x() += 0.01F;
  expect_new("shape");
  scene_.objects[2].begin_s = 3.0;
  expect_new("time of existence");
  light_.sky_seed += 1;
  expect_new("clouds");
}

TEST_F(LightCacheTest, DamagedFilesAreMadeAgain) {
  const auto measured = Make();
  const fs::path file = Files().at(0);
  const auto size = fs::file_size(file);
  const auto spoil = [&](const char* what) {
    const auto made = Make();
    EXPECT_FALSE(made->light().from_cache()) << what;
    ExpectTheSameLight(*measured, *made);
    EXPECT_TRUE(Make()->light().from_cache()) << what;
  };
  fs::resize_file(file, size / 2);
  spoil("cut short");
  fs::resize_file(file, 0);
  spoil("empty");
  std::fstream(file, std::ios::in | std::ios::out | std::ios::binary)
      .seekp(100)
      .put('\x5a')
      .put('\xa5');
  spoil("two bytes");
  std::ofstream(file, std::ios::app) << "more";
  spoil("longer");
}

TEST_F(LightCacheTest, AFolderThatCannotBeMakesNoDifference) {
  light_.cache = "/proc/none/of/this";
  EXPECT_FALSE(Make()->light().from_cache());
  EXPECT_FALSE(Make()->light().from_cache());
}

TEST_F(LightCacheTest, OldFilesGiveWay) {
  const LightCache cache(light_.cache);
  for (std::uint64_t key = 0; key < LightCache::kMostFiles + 4; ++key) cache.Save(key, "light");
  EXPECT_EQ(Files().size(), LightCache::kMostFiles);
}

}  // namespace
}  // namespace kawara::sim
