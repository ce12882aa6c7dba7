#include <gmock/gmock.h>

#include "fixture.hpp"
#include "gis/kiwi/object_register.hpp"

namespace kawara::gis {
namespace {

using namespace testing;

class LateTextures : public ::testing::Test {
 protected:
  std::string Dump(const std::string& name) const {
    return Shell("sqlite3 '" + (folder_ / name).string() +
                 "' 'SELECT * FROM changed_object; SELECT * FROM kp_box; SELECT * FROM kp_texture; "
                 "SELECT * FROM kp_connector'");
  }
  TestFolder folder_;
};

TEST_F(LateTextures, GiveTheRowsTheyWouldHaveGivenInTime) {
  auto in_time = OpenRegister(folder_ / "a.gpkg");
  ASSERT_OK(in_time.Register(Truck(1), Textures()));
  ASSERT_OK(in_time.Close());
  auto late = OpenRegister(folder_ / "b.gpkg");
  ASSERT_OK(late.Register(Truck(1)));
  const auto answer = late.RegisterTextures("truck-1", 1, Textures());
  ASSERT_OK(answer);
  EXPECT_EQ(*answer, Registered::kAdded);
  ASSERT_OK(late.Close());
  EXPECT_FALSE(Dump("a.gpkg").empty());
  EXPECT_EQ(Dump("a.gpkg"), Dump("b.gpkg"));
}

TEST_F(LateTextures, OfARevisionThatIsClosedEndWithIt) {
  auto late = OpenRegister(folder_ / "a.gpkg");
  ASSERT_OK(late.Register(Truck(1, 2.0)));
  ASSERT_OK(late.Register(Truck(2, 5.0)));
  ASSERT_OK(late.RegisterTextures("truck-1", 1, Textures()));
  ASSERT_OK(late.Close());
  EXPECT_EQ(Sql(folder_ / "a.gpkg", "SELECT DISTINCT t_end FROM kp_texture"),
            Sql(folder_ / "a.gpkg", "SELECT t_end FROM changed_object WHERE revision = 1"));
  EXPECT_EQ(Sql(folder_ / "a.gpkg", "SELECT count(texture_uri) FROM changed_object"), "1");
}

TEST_F(LateTextures, OfWhatIsUnknownOrHasThemChangeNothing) {
  auto late = OpenRegister(folder_ / "a.gpkg");
  ASSERT_OK(late.Register(Truck(1)));
  EXPECT_EQ(*late.RegisterTextures("truck-1", 2, Textures()), Registered::kKnown);
  EXPECT_EQ(*late.RegisterTextures("other", 1, Textures()), Registered::kKnown);
  EXPECT_EQ(*late.RegisterTextures("truck-1", 1, {}), Registered::kKnown);
  EXPECT_EQ(*late.RegisterTextures("truck-1", 1, Textures()), Registered::kAdded);
  EXPECT_EQ(*late.RegisterTextures("truck-1", 1, Textures()), Registered::kKnown);
  core::ObjectTextures torn = Textures();
  torn.atlas_jpeg.resize(10);
  EXPECT_FALSE(late.RegisterTextures("truck-1", 1, torn));
  ASSERT_OK(late.Close());
  EXPECT_EQ(Sql(folder_ / "a.gpkg", "SELECT count(*) FROM kp_texture"), "2");
}

}  // namespace
}  // namespace kawara::gis
