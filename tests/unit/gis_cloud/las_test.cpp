#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "gis/model/model_writers.hpp"
#include "tests/support/test_folder.hpp"
#include "tests/unit/gis_cloud/cloud_bytes.hpp"

namespace kawara::gis {
namespace {

using Eigen::Vector3d;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::TestFolder;

TEST(Las, EveryVersionAndPointFormat) {
  const TestFolder folder;
  for (int format = 0; format <= 10; ++format) {
    for (const int minor : {0, 1, 2, 3, 4}) {
      if (format > 5 && minor < 4) continue;
      LasRecipe recipe;
      recipe.minor = minor;
      recipe.format = static_cast<std::uint8_t>(format);
      recipe.extra_bytes = 5;
      const auto all = ReadAll(WriteTo(folder / "a.las", MakeLas(recipe)), {2, 100});
      ASSERT_TRUE(all.info) << format << " " << minor << all.info.error().message;
      ASSERT_EQ(all.points.size(), 3U);
      EXPECT_LT((all.points[2].position - Vector3d(1000.02, 2000.04, 30.06)).norm(), 1e-9);
      EXPECT_EQ(all.points[2].intensity, 14.0F);
      EXPECT_EQ(all.points[2].classification, 2);
      EXPECT_EQ(all.info->has_time, format != 0 && format != 2);
      if (all.info->has_time) {
        EXPECT_EQ(all.points[2].time_s, 102.0) << format;
      }
      const bool colour =
          format == 2 || format == 3 || format == 5 || format == 7 || format == 8 || format == 10;
      EXPECT_EQ(all.info->has_colour, colour) << format;
      if (colour) {
        EXPECT_THAT(all.points[2].colour, Each(2)) << format;
      }
    }
  }
}

TEST(Las, ColoursOfBytesAreKnown) {
  const TestFolder folder;
  LasRecipe recipe;
  recipe.format = 2;
  recipe.colour_step = 100;
  const auto all = ReadAll(WriteTo(folder / "a.las", MakeLas(recipe)));
  EXPECT_THAT(all.points.at(2).colour, Each(200));
}

TEST(Las, WithheldPointsAreCountedNotGiven) {
  const TestFolder folder;
  for (const std::uint8_t format : {std::uint8_t{1}, std::uint8_t{6}}) {
    LasRecipe recipe;
    recipe.minor = 4;
    recipe.format = format;
    std::string las = MakeLas(recipe);
    las[375 + (format == 1 ? 28U : 30U) + 15] = static_cast<char>(format == 1 ? 0x82 : 0x04);
    const auto all = ReadAll(WriteTo(folder / "a.las", las));
    EXPECT_EQ(all.points.size(), 2U);
    EXPECT_EQ(all.info->withheld, 1U);
  }
}

TEST(Las, OurOwnComesBackInTheMap) {
  const TestFolder folder;
  const core::Geodetic origin{35.7 * core::kRadFromDeg, 139.7 * core::kRadFromDeg, 41.25};
  std::vector<core::ColouredPoint> points;
  for (int i = 0; i < 500; ++i)
    points.push_back({{i * 0.731 - 200.0, 150.0 - i * 0.417, (i % 90) * 0.5},
                      {static_cast<std::uint8_t>(i % 256), 20, 255},
                      static_cast<std::uint16_t>(i)});
  ASSERT_TRUE(WriteLas(folder / "m.las", points, origin));
  const auto all = ReadAllEnu((folder / "m.las").string(), {origin});
  ASSERT_TRUE(all.info) << all.info.error().message;
  ASSERT_EQ(all.points.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    // Millimetres in the file, half of one each way, and the fit.
    EXPECT_LT((all.points[i].position - points[i].position_m).norm(), 0.0015);
    EXPECT_THAT(all.points[i].colour, ::testing::ElementsAreArray(points[i].colour));
    EXPECT_EQ(all.points[i].intensity, static_cast<float>(points[i].votes));
  }
}

TEST(Las, TheMapsOriginFromTheBounds) {
  const TestFolder folder;
  const core::Geodetic origin{35.7 * core::kRadFromDeg, 139.7 * core::kRadFromDeg, 41.25};
  const std::array<core::ColouredPoint, 2> points{{{{-10, -20, 5}}, {{10, 20, 9}}}};
  ASSERT_TRUE(WriteLas(folder / "m.las", points, origin));
  const auto info = ReadCloudInfo((folder / "m.las").string());
  ASSERT_TRUE(info);
  const auto found = OriginOf(*info);
  ASSERT_TRUE(found) << found.error().message;
  const Vector3d off = core::LocalEnu(origin).FromGeodetic(*found);
  EXPECT_LT((off - Vector3d(0, 0, 5)).norm(), 0.01);
}

/// GeoTIFF keys of EPSG:32654: WGS 84 / UTM zone 54 north.
std::string KeysOf(std::uint16_t projected) {
  std::string keys;
  for (const int v : {1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1})
    Put(keys, static_cast<std::uint16_t>(v));
  Put(keys, projected);
  return keys;
}

TEST(Las, ReferenceSystemFromKeysAndFromRecordsBehindThePoints) {
  const TestFolder folder;
  LasRecipe by_keys;
  by_keys.records = {{"other", 34735, "xxxx"}, {"LASF_Projection", 34735, KeysOf(32654)}};
  const auto keys = ReadCloudInfo(WriteTo(folder / "k.las", MakeLas(by_keys)));
  ASSERT_TRUE(keys) << keys.error().message;
  EXPECT_THAT(keys->crs, HasSubstr("UTM zone 54N"));
  LasRecipe by_wkt;
  by_wkt.minor = 4;
  by_wkt.format = 6;
  by_wkt.extended = {{"LASF_Projection", 1, "x"},
                     {"LASF_Projection", 2112, std::string("PROJCS[\"JGD\"]\0\0", 15)}};
  const auto wkt = ReadCloudInfo(WriteTo(folder / "w.las", MakeLas(by_wkt)));
  ASSERT_TRUE(wkt) << wkt.error().message;
  EXPECT_EQ(wkt->crs, "PROJCS[\"JGD\"]");
}

TEST(Las, AnUnknownReferenceSystemIsRefusedWithItsName) {
  const TestFolder folder;
  LasRecipe recipe;
  recipe.records = {{"LASF_Projection", 2112, "/etc/passwd"}};
  const auto all = ReadAllEnu(WriteTo(folder / "a.las", MakeLas(recipe)), {});
  ASSERT_FALSE(all.info);
  EXPECT_THAT(all.info.error().message, HasSubstr("\"/etc/passwd\": not known"));
}

TEST(Las, CompressedIsRefusedWithTheCure) {
  const TestFolder folder;
  LasRecipe recipe;
  recipe.records = {{"laszip encoded", 22204, "x"}};
  std::string by_bit = MakeLas({});
  by_bit[104] = static_cast<char>(0x83);
  for (const std::string& las : {MakeLas(recipe), by_bit}) {
    const auto info = ReadCloudInfo(WriteTo(folder / "a.laz", las));
    ASSERT_FALSE(info);
    EXPECT_THAT(info.error().message, HasSubstr("laszip -i FILE.laz -o FILE.las"));
  }
}

TEST(Las, CutOffAnywhereTheWholePointsCome) {
  const TestFolder folder;
  LasRecipe recipe;
  recipe.minor = 4;
  recipe.format = 7;
  recipe.records = {{"LASF_Projection", 34735, KeysOf(32654)}};
  const std::string las = MakeLas(recipe);
  const std::size_t body = las.size() - std::size_t{3} * 36;
  for (std::size_t size = 0; size < las.size(); ++size) {
    const auto all = ReadAll(WriteTo(folder / "cut.las", las.substr(0, size)), {2, 50});
    ASSERT_FALSE(all.info) << size;
    EXPECT_EQ(all.info.error().code, core::ErrorCode::kFormat);
    if (size >= body) {
      EXPECT_EQ(all.points.size(), (size - body) / 36);
      EXPECT_THAT(all.info.error().message,
                  HasSubstr("ends after " + std::to_string((size - body) / 36) + " of 3 points"));
    }
  }
}

TEST(Las, DamagedHeadersAreRefused) {
  struct Case {
    std::size_t at;
    std::string bytes;
    const char* says;
  };
  const auto number = [](double v) {
    std::string bytes;
    Put(bytes, v);
    return bytes;
  };
  const Case cases[] = {
      {24, "\x02", "LAS 2.2"},
      {94, std::string("\x10\0", 2), "a header of 16 bytes"},
      {104, "\x0b", "point format 11"},
      {105, std::string("\x10\0", 2), "points of 16 bytes"},
      {131, number(std::nan("")), "scale or offset"},
      {139, number(0.0), "scale or offset"},
      {96, std::string("\x10\0\0\0", 4), "within its header"},
      {100, "\xff\xff\xff\x7f", "within its variable length records"},
  };
  const TestFolder folder;
  for (const Case& c : cases) {
    std::string las = MakeLas({});
    las.replace(c.at, c.bytes.size(), c.bytes);
    const auto all = ReadAll(WriteTo(folder / "bad.las", las));
    ASSERT_FALSE(all.info) << c.says;
    EXPECT_THAT(all.info.error().message, HasSubstr(c.says));
  }
}

}  // namespace
}  // namespace kawara::gis
