#include "vision/change/change_watch.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "street.hpp"

namespace kawara::vision {
namespace {

using test_support::Car;
using test_support::Street;
using test_support::Truck;

constexpr double kKnown = 16.0;  // m

core::UtcTime At(double x) {
  return core::UtcTime::FromNs(static_cast<std::int64_t>((1000.0 + x) * 1e9));
}

Street Walls(std::uint32_t seed) {
  Street street(seed);
  street.AddGround();
  street.AddWalls();
  return street;
}

KnownPlace Before() {
  ReferenceMap reference = Walls(7).Reference();
  reference.roads = Street::Road().polygons();
  return *KnownPlace::Of(std::move(reference));
}

/// All that was told on a drive along the street, by where it was told.
struct Told {
  std::vector<std::pair<double, ChangeNews>> news;

  std::vector<std::pair<double, core::ChangedObject>> Of(const std::string& uid) const {
    std::vector<std::pair<double, core::ChangedObject>> revisions;
    for (const auto& [x, one] : news)
      for (const auto& object : one.revisions)
        if (object.uid == uid) revisions.emplace_back(x, object);
    return revisions;
  }
  std::set<std::string> uids() const {
    std::set<std::string> all;
    for (const auto& [x, one] : news)
      for (const auto& object : one.revisions) all.insert(object.uid);
    return all;
  }
  std::vector<std::string> settled() const {
    std::vector<std::string> all;
    for (const auto& [x, one] : news)
      for (const auto& object : one.settled) all.push_back(object.uid);
    return all;
  }
};

Told Drive(ChangeWatch& watch, const Street& street, double from = -20.0, double to = 20.0,
           double known_m = kKnown) {
  auto map = *VoxelMap::Create({.voxel_m = 0.2});
  Told told;
  for (double x = from; x <= to; x += 0.5) {
    const Eigen::Vector3d eye = Street::Eye(x);
    EXPECT_TRUE(map.Vote(street.VotesFrom(eye)));
    if (!watch.IsDue(eye)) continue;
    told.news.emplace_back(x, watch.Look(map, eye, known_m, At(x)));
  }
  return told;
}

TEST(ChangeWatch, TellsOfAThingBeforeTheRobotHasPassedItAndBettersIt) {
  Street street = Walls(8);
  const core::UprightBox truck = Truck(10.0, 2.6, 92.0), car = Car(-8.0, 2.9, 88.0);
  street.AddBox(truck);
  street.AddBox(car);
  ChangeWatch watch(Before(), {.tracker = {.uid_prefix = "s"}});
  const Told told = Drive(watch, street);
  ASSERT_EQ(told.uids(), (std::set<std::string>{"s-1", "s-2"}));
  const auto of_car = told.Of("s-1"), of_truck = told.Of("s-2");
  EXPECT_LT(of_car.front().first, car.centre_m.x() - car.size_m.x() / 2);
  EXPECT_LT(of_truck.front().first, truck.centre_m.x() - truck.size_m.x() / 2);
  for (const auto& revisions : {of_car, of_truck}) {
    EXPECT_LE(revisions.size(), 12U);
    for (std::size_t i = 0; i < revisions.size(); ++i)
      EXPECT_EQ(revisions[i].second.revision, i + 1);
  }
  EXPECT_LT((of_car.back().second.box.centre_m - car.centre_m).norm(), 0.25);
  EXPECT_LT((of_truck.back().second.box.centre_m - truck.centre_m).norm(), 0.25);
  EXPECT_EQ(of_truck.front().second.first_seen, At(of_truck.front().first));
  // The car was left behind; the truck, at the end of the drive, not yet.
  EXPECT_EQ(told.settled(), std::vector<std::string>{"s-1"});
  const auto rest = watch.Settle();
  ASSERT_EQ(rest.size(), 1U);
  EXPECT_EQ(rest.front().uid, "s-2");
  EXPECT_TRUE(watch.Settle().empty());
}

TEST(ChangeWatch, TellsNothingOfAStreetWhereNothingChanged) {
  ChangeWatch watch(Before(), {});
  const Told told = Drive(watch, Walls(9));
  EXPECT_TRUE(told.uids().empty());
  std::map<double, int> times;
  for (const auto& [x, news] : told.news)
    for (const auto& station : news.stations) ++times[station.along_m];
  EXPECT_GT(times.size(), 70U);  // of 80 along 40 m
  for (const auto& [along, count] : times) EXPECT_LE(count, 4) << along;
}

TEST(ChangeWatch, WhatMemoryHoldsOnlyAPartOfIsNotTold) {
  Street street = Walls(8);
  street.AddBox(Truck(6.0, 2.6));
  const VoxelMap map = street.Look();
  const auto told = [&](double known_m) {
    ChangeWatch watch(Before(), {});
    std::size_t revisions = 0;
    for (const double x : {3.0, 3.5, 4.0})
      revisions += watch.Look(map, Street::Eye(x), known_m, At(x)).revisions.size();
    return revisions;
  };
  EXPECT_EQ(told(6.0), 0U);
  EXPECT_EQ(told(kKnown), 1U);
}

TEST(ChangeWatch, GoesOnAfterARestartWithoutNewUids) {
  Street street = Walls(8);
  street.AddBox(Truck(6.0, 2.6));
  ChangeWatch first(Before(), {.tracker = {.uid_prefix = "s"}});
  Drive(first, street);
  ASSERT_EQ(first.objects().size(), 1U);
  ChangeWatch second(Before(), {.tracker = {.uid_prefix = "s"}});
  second.TakeUp(first.objects(), true);
  const Told told = Drive(second, street);
  for (const auto& uid : told.uids()) EXPECT_EQ(uid, "s-1");
  EXPECT_EQ(second.objects().size(), 1U);
}

TEST(ChangeWatch, ASecondMissionClosesWhatHasLeftAndOnlyThat) {
  Street first_day = Walls(8);
  const core::UprightBox truck = Truck(6.0, 2.6), car = Car(-8.0, 2.9);
  first_day.AddBox(truck);
  first_day.AddBox(car);
  ChangeWatch first(Before(), {.tracker = {.uid_prefix = "one"}});
  Drive(first, first_day);
  ASSERT_EQ(first.objects().size(), 2U);

  Street second_day = Walls(10);
  second_day.AddBox(truck);
  ChangeWatch second(Before(), {.tracker = {.uid_prefix = "two"}});
  second.TakeUp(first.objects(), false);
  const Told told = Drive(second, second_day);
  EXPECT_EQ(told.uids(), (std::set<std::string>{"one-1", "one-2"}));
  EXPECT_EQ(told.Of("one-1").back().second.state, core::ChangeState::kGone);
  for (const auto& [x, object] : told.Of("one-2"))
    EXPECT_EQ(object.state, core::ChangeState::kConfirmed);
  ASSERT_EQ(second.objects().size(), 1U);
  EXPECT_EQ(second.objects().front().uid, "one-2");
}

TEST(ChangeWatch, SaysWhenTheMapDoesNotFitAndSubtractsNothing) {
  AlignOptions strict;
  strict.max_shift_m = 0.0;
  strict.max_turn_rad = 0.0;
  Street street = Walls(8);
  street.AddBox(Truck(6.0, 2.6));
  // The whole street 12 cm to the side.
  auto map = *VoxelMap::Create({.voxel_m = 0.2});
  for (double x = -4; x <= 4; x += 1.0) {
    auto votes = street.VotesFrom(Street::Eye(x));
    for (PointVote& vote : votes) vote.position_m.y() += 0.12;
    ASSERT_TRUE(map.Vote(votes));
  }
  ChangeWatch watch(Before(), {.alignment = strict});
  const ChangeNews news = watch.Look(map, Street::Eye(4.0), kKnown, At(4.0));
  EXPECT_NE(news.trouble.find("beyond reason"), std::string::npos) << news.trouble;
  EXPECT_TRUE(news.revisions.empty());
  EXPECT_TRUE(news.stations.empty());
}

}  // namespace
}  // namespace kawara::vision
