#include "vision/change/object_tracker.hpp"

#include <gtest/gtest.h>

namespace kawara::vision {
namespace {

core::UtcTime At(std::int64_t s) { return core::UtcTime::FromNs(s * 1'000'000'000); }

FoundChange Thing(double x, double y, double length = 4.4) {
  FoundChange change;
  change.object.box = {{x, y, 0.75}, {length, 1.7, 1.5}, 1.57};
  change.object.covariance.setIdentity();
  change.object.covariance *= 0.01;
  return change;
}

Findings Look(std::vector<FoundChange> changes) {
  Findings findings;
  findings.changes = std::move(changes);
  return findings;
}

/// Ground seen all over a place.
void SeeGround(Findings& findings, double x, double y, double half = 4.0) {
  for (double a = -half; a <= half; a += 0.2)
    for (double b = -half; b <= half; b += 0.2)
      findings.look.ground_seen.insert(ChangePoints::GroundKey({x + a, y + b}));
}

TEST(ObjectTracker, TheSameThingKeepsItsUidAndTellsNothingNewTwice) {
  ObjectTracker tracker({.uid_prefix = "s", .robot = "r1"});
  const auto first = tracker.Update(Look({Thing(0, 0), Thing(10, 0)}), At(100), At(1));
  ASSERT_EQ(first.size(), 2U);
  EXPECT_EQ(first[0].uid, "s-1");
  EXPECT_EQ(first[1].uid, "s-2");
  EXPECT_EQ(first[0].revision, 1U);
  EXPECT_EQ(first[0].last_absent, At(1));
  EXPECT_EQ(first[0].robots, std::vector<std::string>{"r1"});
  EXPECT_TRUE(tracker.Update(Look({Thing(0.02, 0), Thing(10, 0)}), At(101), At(1)).empty());
  const auto better = tracker.Update(Look({Thing(0.3, 0), Thing(10, 0)}), At(102), At(1));
  ASSERT_EQ(better.size(), 1U);
  EXPECT_EQ(better[0].uid, "s-1");
  EXPECT_EQ(better[0].revision, 2U);
  EXPECT_EQ(better[0].first_seen, At(100));
  EXPECT_EQ(better[0].last_seen, At(102));
}

TEST(ObjectTracker, NotSeenIsNeverGone) {
  ObjectTracker tracker({.uid_prefix = "s"});
  tracker.Update(Look({Thing(0, 0)}), At(100), {});
  EXPECT_TRUE(tracker.Update(Look({}), At(200), {}).empty());
  EXPECT_EQ(tracker.objects().size(), 1U);
}

TEST(ObjectTracker, BareGroundWhereItStoodClosesIt) {
  ObjectTracker before({.uid_prefix = "s"});
  before.Update(Look({Thing(0, 0), Thing(12, 0)}), At(100), {});
  ObjectTracker tracker({.uid_prefix = "t"});
  tracker.TakeUp(before.objects());
  Findings findings = Look({Thing(12, 0)});
  SeeGround(findings, 0, 0);
  const auto told = tracker.Update(findings, At(500), {});
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(told[0].uid, "s-2");
  EXPECT_EQ(told[0].state, core::ChangeState::kConfirmed);
  EXPECT_EQ(told[1].uid, "s-1");
  EXPECT_EQ(told[1].state, core::ChangeState::kGone);
  EXPECT_EQ(told[1].gone, At(500));
  EXPECT_EQ(tracker.objects().size(), 1U);
}

TEST(ObjectTracker, WhatLeftItsPlaceAndStandsNearbyHasMoved) {
  ObjectTracker before({.uid_prefix = "s"});
  before.Update(Look({Thing(0, 0)}), At(100), {});
  ObjectTracker tracker({.uid_prefix = "t"});
  tracker.TakeUp(before.objects());
  Findings findings = Look({Thing(9, 1)});
  SeeGround(findings, 0, 0);
  const auto told = tracker.Update(findings, At(500), {});
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].uid, "s-1");
  EXPECT_EQ(told[0].state, core::ChangeState::kMoved);
  EXPECT_EQ(told[0].first_seen, At(500));
}

TEST(ObjectTracker, AnotherPassFindsItGrown) {
  ObjectTracker before({.uid_prefix = "s"});
  before.Update(Look({Thing(0, 0, 2.0)}), At(100), {});
  ObjectTracker tracker({.uid_prefix = "t"});
  tracker.TakeUp(before.objects());
  const auto told = tracker.Update(Look({Thing(0.4, 0, 4.0)}), At(500), {});
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].uid, "s-1");
  EXPECT_EQ(told[0].state, core::ChangeState::kGrown);
}

TEST(ObjectTracker, NumbersGoOnAfterThoseThatAreKnown) {
  ObjectTracker before({.uid_prefix = "s"});
  before.Update(Look({Thing(0, 0), Thing(20, 0)}), At(100), {});
  ObjectTracker tracker({.uid_prefix = "s"});
  tracker.TakeUp(before.objects());
  const auto told = tracker.Update(Look({Thing(60, 0)}), At(500), {});
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].uid, "s-3");
}

TEST(ObjectTracker, ALookThatShowsLessChangesNothingButThatItIsThere) {
  ObjectTracker before({.uid_prefix = "s"});
  before.Update(Look({Thing(0, 0, 7.0)}), At(100), {});
  ObjectTracker tracker({.uid_prefix = "t"});
  tracker.TakeUp(before.objects());
  FoundChange part = Thing(-2.5, 0, 2.0);
  const auto first = tracker.Update(Look({part}), At(500), {});
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].uid, "s-1");
  EXPECT_EQ(first[0].state, core::ChangeState::kConfirmed);
  EXPECT_EQ(first[0].box.size_m.x(), 7.0);
  EXPECT_EQ(first[0].last_seen, At(500));
  EXPECT_TRUE(tracker.Update(Look({part}), At(501), {}).empty());
  // Surer of it than ever before: then it is news.
  part.object.covariance *= 0.1;
  const auto sure = tracker.Update(Look({part}), At(502), {});
  ASSERT_EQ(sure.size(), 1U);
  EXPECT_EQ(sure[0].box.size_m.x(), 2.0);
}

TEST(ObjectTracker, WhatWasTakenForAThingAndIsAPartOfAnotherIsClosedAndTheOlderUidStays) {
  ObjectTracker tracker({.uid_prefix = "s"});
  tracker.Update(Look({Thing(0, 0, 3.0)}), At(100), {});
  tracker.Update(Look({Thing(0, 0, 3.0), Thing(3.0, 0, 1.0)}), At(101), {});
  ASSERT_EQ(tracker.objects().size(), 2U);
  FoundChange whole = Thing(1.0, 0, 7.0);
  whole.object.covariance *= 0.1;
  const auto told = tracker.Update(Look({whole}), At(102), {});
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(told[0].uid, "s-1");
  EXPECT_EQ(told[1].uid, "s-2");
  EXPECT_EQ(told[1].state, core::ChangeState::kGone);
  EXPECT_EQ(tracker.objects().size(), 1U);
}

TEST(ObjectTracker, UidsThatSomebodyElseHasGivenAwayAreLeftOut) {
  ObjectTracker tracker(
      {.uid_prefix = "s", .taken = [](const std::string& uid) { return uid == "s-1"; }});
  core::ChangedObject gone = Thing(50, 0).object;
  gone.uid = "s-2";
  gone.state = core::ChangeState::kGone;
  tracker.TakeUp({gone});
  EXPECT_TRUE(tracker.objects().empty());
  const auto told = tracker.Update(Look({Thing(0, 0)}), At(100), {});
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].uid, "s-3");
}

TEST(ObjectTracker, WhatLiesAheadIsNotCalledGone) {
  ObjectTracker before({.uid_prefix = "s"});
  before.Update(Look({Thing(0, 0)}), At(100), {});
  const auto told = [&](double ahead_x) {
    ObjectTracker tracker({.uid_prefix = "t"});
    tracker.TakeUp(before.objects());
    Findings findings = Look({});
    SeeGround(findings, 0, 0);
    findings.within = PlaneDisc{{-6.0, 0.0}, 20.0};
    findings.ahead = Eigen::Vector2d(ahead_x, 0.0);
    return tracker.Update(findings, At(500), {}).size();
  };
  EXPECT_EQ(told(1.0), 0U);
  EXPECT_EQ(told(-1.0), 1U);
}

}  // namespace
}  // namespace kawara::vision
