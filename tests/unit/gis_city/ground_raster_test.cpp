#include "gis/city/ground_raster.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "gis/frame/crs_to_enu.hpp"
#include "tests/support/test_folder.hpp"
#include "tests/unit/gis_city/city_files.hpp"

namespace kawara::gis {
namespace {

using ::testing::HasSubstr;
using testing::TestFolder;

const core::Geodetic kOrigin{35.7 * core::kRadFromDeg, 139.7 * core::kRadFromDeg, 41.25};
constexpr MapFrame kLocal{{}, Coordinates::kLocalMetres};

/// Three columns, two rows of 2 m from (-3, -2): the middles lie at x -2, 0, 2 and y 1, -1.
constexpr const char* kGrid =
    "ncols 3\nnrows 2\nxllcorner -3\nyllcorner -2\ncellsize 2\nNODATA_value -9999\n"
    "1 2 3\n11 12 -9999\n";

TEST(GroundRaster, BilinearBetweenTheMiddlesOfCells) {
  const TestFolder folder;
  const auto ground = GroundRaster::Read(WriteTo(folder / "g.asc", kGrid), kLocal);
  ASSERT_TRUE(ground) << ground.error().message;
  EXPECT_EQ(ground->known_cells(), 5U);
  EXPECT_NEAR(ground->cell_m(), 2.0, 1e-9);
  const std::tuple<double, double, std::optional<double>> cases[] = {
      {-2, 1, 1.0},
      {0, 1, 2.0},
      {-1, 1, 1.5},
      {-1, 0, 6.5},
      {-2.9, 1, 1.0} /* outer half */,
      {2, 1, 3.0},
      {2, -1, std::nullopt},
      {1, 1, 2.5},
      {-3.1, 0, std::nullopt},
      {0, 2.1, std::nullopt},
  };
  for (const auto& [e, n, up] : cases) {
    const auto found = ground->HeightAt(e, n);
    ASSERT_EQ(found.has_value(), up.has_value()) << e << " " << n;
    if (up) {
      EXPECT_NEAR(*found, *up, 1e-6) << e << " " << n;
    }
  }
  EXPECT_FALSE(ground->HeightAt(std::nan(""), 0));
}

TEST(GroundRaster, CellsWithoutDataCountByWeight) {
  const TestFolder folder;
  const auto ground = GroundRaster::Read(WriteTo(folder / "g.asc", kGrid), kLocal);
  ASSERT_TRUE(ground);
  EXPECT_NEAR(ground->HeightAt(0.5, -1).value(), 12.0, 1e-6);  // three quarters known
  EXPECT_FALSE(ground->HeightAt(1.5, -1));
}

TEST(GroundRaster, InTheReferenceSystemOfTheFile) {
  const TestFolder folder;
  const MapFrame frame{kOrigin, Coordinates::kFromFile, 36.5};
  auto crs = CrsToEnu::Make("EPSG:32654", frame);
  ASSERT_TRUE(crs);
  const Eigen::Vector2d middle = crs->Back({0, 0, 0});
  // Half a metre up for each 10 m of easting.
  constexpr int kCells = 60;
  std::string grid = "ncols 60\nnrows 60\nxllcorner " + std::to_string(middle.x() - 300) +
                     "\nyllcorner " + std::to_string(middle.y() - 300) + "\ncellsize 10\n";
  for (int r = 0; r < kCells; ++r) {
    for (int c = 0; c < kCells; ++c) grid += std::to_string(c * 0.5) + " ";
    grid += "\n";
  }
  const std::string path = WriteTo(folder / "g.asc", grid);
  WriteTo(folder / "g.prj",
          "PROJCS[\"WGS 84 / UTM zone 54N\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS "
          "84\",6378137,298.257223563]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\","
          "0.0174532925199433]],PROJECTION[\"Transverse_Mercator\"],PARAMETER["
          "\"latitude_of_origin\",0],PARAMETER[\"central_meridian\",141],PARAMETER["
          "\"scale_factor\",0.9996],PARAMETER[\"false_easting\",500000],PARAMETER["
          "\"false_northing\",0],UNIT[\"metre\",1]]");
  const auto ground = GroundRaster::Read(path, frame);
  ASSERT_TRUE(ground) << ground.error().message;
  EXPECT_NEAR(ground->cell_m(), 10.0, 0.01);
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(0, 0), {123.4, -200.5}, {-250, 260}}) {
    const Eigen::Vector2d xy = crs->Back({p.x(), p.y(), 0});
    const double height = ((xy.x() - (middle.x() - 300)) / 10.0 - 0.5) * 0.5;
    const Eigen::Vector3d want = crs->Exact({xy.x(), xy.y(), height});
    const auto up = ground->HeightAt(p.x(), p.y());
    ASSERT_TRUE(up);
    EXPECT_NEAR(*up, want.z(), 0.002);
  }
  EXPECT_FALSE(ground->HeightAt(400, 0));
  const auto near_only = GroundRaster::Read(path, frame, {.radius_m = 50});
  ASSERT_TRUE(near_only);
  EXPECT_LT(near_only->columns(), 16);
  EXPECT_NEAR(near_only->HeightAt(10, 20).value(), ground->HeightAt(10, 20).value(), 5e-4);
}

TEST(GroundRaster, RefusalsSayHowToMend) {
  const TestFolder folder;
  const std::string grid = WriteTo(folder / "g.asc", kGrid);
  struct Case {
    std::string path;
    MapFrame frame;
    GroundOptions options;
    core::ErrorCode code;
    const char* says;
  };
  const Case cases[] = {
      {(folder / "none.tif").string(), kLocal, {}, core::ErrorCode::kNotFound, "no such file"},
      {WriteTo(folder / "t.tif", "hello"), kLocal, {}, core::ErrorCode::kFormat, "no raster"},
      {grid, {kOrigin}, {}, core::ErrorCode::kInvalidArgument, "local metres"},
      {grid, kLocal, {.band = 2}, core::ErrorCode::kInvalidArgument, "no band 2 (it has 1)"},
      {WriteTo(folder / "far.asc",
               "ncols 1\nnrows 1\nxllcorner 90000\nyllcorner 0\ncellsize 1\n5\n"),
       kLocal,
       {},
       core::ErrorCode::kInvalidArgument,
       "nothing of it lies within 5000 m"},
  };
  for (const Case& c : cases) {
    const auto ground = GroundRaster::Read(c.path, c.frame, c.options);
    ASSERT_FALSE(ground) << c.says;
    EXPECT_EQ(ground.error().code, c.code) << ground.error().message;
    EXPECT_THAT(ground.error().message, HasSubstr(c.says));
  }
}

}  // namespace
}  // namespace kawara::gis
