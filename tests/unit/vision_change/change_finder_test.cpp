#include "vision/change/change_finder.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "tests/unit/vision_change/street.hpp"

namespace kawara::vision {
namespace {

using test_support::Car;
using test_support::Street;
using test_support::Truck;

double Off(double a, double b) { return std::abs(core::WrapPi(2.0 * (a - b)) / 2.0); }

Findings Find(const Street& now, const ReferenceMap& reference, const FinderOptions& options = {}) {
  const RoadArea road = Street::Road();
  return FindChanges(now.Look(), {reference, road, AxesOf(road)}, Eigen::Isometry3d::Identity(),
                     options);
}

ReferenceMap Before() {
  Street street(7);
  street.AddGround();
  street.AddWalls();
  return street.Reference();
}

Street After() {
  Street street(8);
  street.AddGround();
  street.AddWalls();
  return street;
}

TEST(ChangeFinder, FindsNothingWhereNothingChanged) {
  const Findings found = Find(After(), Before());
  EXPECT_TRUE(found.changes.empty());
  EXPECT_TRUE(found.look.points.empty());
  EXPECT_GT(found.look.ground_seen.size(), 1000U);
}

TEST(ChangeFinder, BoxesOfTruckAndCarAreThoseThatStandThere) {
  Street street = After();
  const core::UprightBox truck = Truck(6.0, 2.6, 92.0), car = Car(-8.0, 2.9, 88.0);
  street.AddBox(truck);
  street.AddBox(car);
  const Findings found = Find(street, Before());
  ASSERT_EQ(found.changes.size(), 2U);
  for (const auto& [truth, index] : {std::pair{truck, 0}, std::pair{car, 1}}) {
    const core::ChangedObject& object = found.changes[static_cast<std::size_t>(index)].object;
    EXPECT_LT((object.box.centre_m - truth.centre_m).norm(), 0.25);
    EXPECT_NEAR(object.box.size_m.x(), truth.size_m.x(), 0.2);
    EXPECT_NEAR(object.box.size_m.y(), truth.size_m.y(), 0.35);
    EXPECT_NEAR(object.box.size_m.z(), truth.size_m.z(), 0.15);
    EXPECT_LT(Off(object.box.heading_rad, truth.heading_rad), 1.5 * core::kRadFromDeg);
    EXPECT_GT(object.existence_probability, 0.9);
    // The near side was seen, the far one was not: its error is its own.
    EXPECT_TRUE(object.side_seen[static_cast<std::size_t>(core::BoxSide::kRight)]);
    EXPECT_FALSE(object.side_seen[static_cast<std::size_t>(core::BoxSide::kLeft)]);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 7, 7>> eigen(object.covariance);
    EXPECT_GT(eigen.eigenvalues()[0], -1e-12);
  }
  EXPECT_EQ(found.changes[0].object.size_class, core::SizeClass::kTruck);
  EXPECT_EQ(found.changes[1].object.size_class, core::SizeClass::kCar);
}

TEST(ChangeFinder, WithoutSurfacesInTheReferenceTheRoadAloneDecides) {
  Street street = After();
  street.AddBox(Car(0.0, 2.5));
  ReferenceMap flat;
  flat.ground = Before().ground;
  const Findings found = Find(street, flat);
  ASSERT_EQ(found.changes.size(), 1U);
  EXPECT_NEAR(found.changes[0].object.box.centre_m.x(), 0.0, 0.2);
}

TEST(ChangeFinder, RoadLeftToPassIsMeasured) {
  Street street = After();
  const core::UprightBox truck = Truck(6.0, 2.9);
  street.AddBox(truck);
  const Findings found = Find(street, Before());
  ASSERT_EQ(found.changes.size(), 1U);
  int beside = 0, free = 0;
  for (const core::RoadStation& station : found.stations) {
    const double x = (station.left_m.x() + station.right_m.x()) / 2.0;
    if (std::abs(x) > 17.0) continue;
    EXPECT_NEAR(station.road_width_m, 8.0, 0.05);
    if (std::abs(x - 6.0) < 3.0) {
      ++beside;
      EXPECT_NEAR(station.passable_m, 8.0 - (4.0 - 1.8), 0.12);
      EXPECT_LT(station.passable_m - 2.0 * station.passable_sd_m, 5.8);
      EXPECT_EQ(station.passable_class, 3U);
    } else if (std::abs(x - 6.0) > 4.5) {
      ++free;
      EXPECT_NEAR(station.passable_m, 8.0, 0.05);
    }
  }
  EXPECT_GE(beside, 10);
  EXPECT_GE(free, 30);
}

TEST(ChangeFinder, HowTheMapsFitCountsBesideThingsAndNotOnTheFreeRoad) {
  Street street = After();
  street.AddBox(Truck(6.0, 2.9));
  FinderOptions doubtful;
  doubtful.width.fit_covariance_m2 = Eigen::Vector2d(0.5, 0.2 * 0.2).asDiagonal();
  const Findings sure = Find(street, Before()), doubt = Find(street, Before(), doubtful);
  ASSERT_EQ(sure.stations.size(), doubt.stations.size());
  int beside = 0, free = 0;
  for (std::size_t i = 0; i < sure.stations.size(); ++i) {
    const core::RoadStation &a = sure.stations[i], &b = doubt.stations[i];
    const bool whole = a.passable_m > a.road_width_m - 0.01;
    EXPECT_NEAR(b.passable_sd_m, std::hypot(a.passable_sd_m, whole ? 0.0 : 0.2), 1e-9);
    ++(whole ? free : beside);
  }
  EXPECT_GE(beside, 10);
  EXPECT_GE(free, 30);
}

TEST(ChangeFinder, WhatHangsOverTheRoadAndWhatIsLowDoesNotBlockIt) {
  Street street = After();
  street.AddBox({{0.0, 0.0, 3.6}, {3.0, 3.0, 0.6}, 0.0});     // a banner
  street.AddBox({{-8.0, 1.0, 0.08}, {2.0, 2.0, 0.16}, 0.0});  // a plate on the ground
  EXPECT_TRUE(Find(street, Before()).changes.empty());
}

TEST(ChangeFinder, PapersMethodBoxesTheSameThings) {
  Street street = After();
  street.AddBox(Car(0.0, 2.0));
  FinderOptions options;
  options.method = ChangeMethod::kPaper;
  const Findings found = Find(street, Before(), options);
  ASSERT_EQ(found.changes.size(), 1U);
  EXPECT_NEAR(found.changes[0].object.box.size_m.x(), 4.4, 0.3);
}

TEST(ChangeFinder, TheSameLookGivesTheSameBytes) {
  Street street = After();
  street.AddBox(Car(0.0, 2.0));
  const Findings a = Find(street, Before()), b = Find(street, Before());
  ASSERT_EQ(a.changes.size(), b.changes.size());
  EXPECT_EQ(a.changes[0].object.box.centre_m, b.changes[0].object.box.centre_m);
  EXPECT_EQ(a.changes[0].object.covariance, b.changes[0].object.covariance);
}

}  // namespace
}  // namespace kawara::vision
