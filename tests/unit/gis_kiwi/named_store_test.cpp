#include <cstdlib>

#include "fixture.hpp"

// The same calls into a store that the environment names: tests/hil/test_kiwi_stores.py compares
// what a GeoPackage and PostGIS hold after them, and what QGIS and kawara-evaluate see.
namespace kawara::gis {
namespace {

using namespace testing;

TEST(NamedStore, TakesTwoMissions) {
  const char* target = std::getenv("KAWARA_TEST_STORE");
  if (target == nullptr) GTEST_SKIP() << "KAWARA_TEST_STORE names no store";
  core::ChangedObject wagon = Truck();
  wagon.uid = "wagon-2";
  wagon.size_class = core::SizeClass::kCar;
  wagon.box = {.centre_m = {12.0, -4.0, 0.75}, .size_m = {4.4, 1.7, 1.5}, .heading_rad = 0.3};
  wagon.first_seen = At(20);
  wagon.last_seen = At(25);
  {
    auto first = OpenRegister(target);
    ASSERT_OK(first.Register(Truck(1, 2.0), Textures(), At(3)));
    ASSERT_OK(first.Register(wagon, {}, At(26)));
    ASSERT_OK(first.Register(Truck(2, 30.0), Textures(), At(31)));
    ASSERT_OK(first.RegisterStations({{Station(0.5, 3.2, 1.0), Station(1.0, 1.9, 1.0)}}, At(60)));
    ASSERT_OK(first.Close());
  }
  auto second = OpenRegister(target);
  const auto known = second.ObjectsAt(At(86400));
  ASSERT_OK(known);
  ASSERT_EQ(known->size(), 2U);
  for (const core::ChangedObject& object : *known) {
    if (object.uid != "wagon-2") continue;
    ASSERT_OK(second.Register(Gone(object, 86500.0), {}, At(86501)));
  }
  EXPECT_EQ(second.LastRevision("truck-1").value(), 2U);
  EXPECT_EQ(second.ObjectsAt(At(86499)).value().size(), 2U);
  EXPECT_EQ(second.ObjectsAt(At(86500)).value().size(), 1U);
  ASSERT_OK(second.Close());
}

}  // namespace
}  // namespace kawara::gis
