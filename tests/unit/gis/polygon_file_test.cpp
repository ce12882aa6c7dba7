#include "gis/polygon_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "gis/ogr_dataset.hpp"

namespace kawara::gis {
namespace {

class PolygonFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("kawara_polygons_" + std::to_string(::getpid()) + "_" +
               testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string Path() const { return (folder_ / "t.gpkg").string(); }
  static PolygonLayer Layer() {
    return {"boxes",
            "Boxes",
            {{"name", FieldType::kText, true},
             {"height_m", FieldType::kReal, false},
             {"known", FieldType::kFlag, true}},
            {{{{{139, 35, 5}, {139.1, 35, 5}, {139.1, 35.1, 5}}, {{1, 1, 0}, {2, 1, 0}, {2, 2, 0}}},
              {std::string("a"), 2.5, true}},
             {{{{1, 1, 0}, {2, 1, 0}, {2, 2, 0}}}, {std::string("b"), {}, false}}}};
  }
  std::filesystem::path folder_;
};

TEST_F(PolygonFile, ReadsBackWithValuesAndNulls) {
  const PolygonLayer layer = Layer();
  const auto written = WritePolygonFile(Path(), {&layer, 1});
  ASSERT_TRUE(written) << written.error().message;
  auto dataset = OgrDataset::Open(Path(), true);
  ASSERT_TRUE(dataset);
  const auto count = [&](const std::string& where) {
    return dataset->QueryInteger("SELECT count(*) AS n FROM boxes WHERE " + where).value();
  };
  EXPECT_EQ(count("name = 'a' AND height_m = 2.5 AND known = 1"), 1);
  EXPECT_EQ(count("name = 'b' AND height_m IS NULL AND known = 0"), 1);
  EXPECT_EQ(count("ST_GeometryType(geom) = 'MULTIPOLYGON'"), 2);
}

TEST_F(PolygonFile, TakesThePlaceOfAnOlderFile) {
  PolygonLayer layer = Layer();
  ASSERT_TRUE(WritePolygonFile(Path(), {&layer, 1}));
  layer.features.pop_back();
  ASSERT_TRUE(WritePolygonFile(Path(), {&layer, 1}));
  auto dataset = OgrDataset::Open(Path(), true);
  ASSERT_TRUE(dataset);
  EXPECT_EQ(dataset->QueryInteger("SELECT count(*) AS n FROM boxes").value(), 1);
}

TEST_F(PolygonFile, WrongNumberOfValuesLeavesNoFile) {
  PolygonLayer layer = Layer();
  layer.features[1].values.pop_back();
  const auto written = WritePolygonFile(Path(), {&layer, 1});
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, core::ErrorCode::kInvalidArgument);
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

}  // namespace
}  // namespace kawara::gis
