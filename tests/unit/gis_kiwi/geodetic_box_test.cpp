#include "gis/kiwi/geodetic_box.hpp"

#include "fixture.hpp"

namespace kawara::gis {
namespace {

using namespace testing;

const core::Geodetic kOther{kOrigin.lat_rad + 1e-4, kOrigin.lon_rad - 1e-4, 40.0};  // 900 m off

TEST(GeodeticBox, IsTheSameThingInAnotherMap) {
  const core::LocalEnu here(kOrigin), there(kOther);
  const core::ChangedObject truck = Truck();
  const core::ChangedObject moved = InMap(truck, here, there);
  const auto was = truck.box.Apexes(), is = moved.box.Apexes();
  for (std::size_t i = 0; i < was.size(); ++i)
    EXPECT_LT((there.FromGeodetic(here.ToGeodetic(was[i])) - is[i]).norm(), 1e-3) << i;
  EXPECT_NEAR(moved.second_heading_rad.value() - moved.box.heading_rad, core::kPi / 2, 1e-12);
}

TEST(GeodeticBox, ComesBackFromAnotherMap) {
  const core::LocalEnu here(kOrigin), there(kOther);
  const core::UprightBox box = Truck().box;
  const core::UprightBox back = InMap(InMap(Truck(), here, there), there, here).box;
  EXPECT_LT((back.centre_m - box.centre_m).norm(), 1e-7);
  EXPECT_NEAR(back.heading_rad, box.heading_rad, 1e-12);
}

// 10 km east at 35.7 degrees true north has turned by 10 / 6378 * tan(35.7 degrees).
TEST(GeodeticBox, HeadingsAreTrueWhereTheBoxStands) {
  core::UprightBox box = Truck().box;
  box.centre_m = {10'000.0, 0.0, 0.0};
  const double turned = box.heading_rad - GeodeticOf(box, core::LocalEnu(kOrigin)).heading_rad;
  EXPECT_NEAR(turned, -10.0 / 6386.0 * std::tan(kOrigin.lat_rad), 1e-6);
}

}  // namespace
}  // namespace kawara::gis
