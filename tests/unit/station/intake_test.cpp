#include "station/intake.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "packets.hpp"

namespace kawara::station {
namespace {

using namespace testing;
using ::testing::HasSubstr;

class IntakeTest : public ::testing::Test {
 protected:
  Intake Make(double pose_rate_hz = 1.0) {
    StationConfig config;
    config.pose_rate_hz = pose_rate_hz;
    config.max_picture_mb = 0.1;
    return Intake(config, [this](Item item) { items_.push_back(std::move(item)); });
  }
  std::vector<gis::PoseRecord> Poses() const {
    std::vector<gis::PoseRecord> poses;
    for (const Item& item : items_)
      if (const auto* p = std::get_if<gis::PoseRecord>(&item.record)) poses.push_back(*p);
    return poses;
  }
  std::vector<Item> items_;
};

TEST_F(IntakeTest, APacketBecomesAPictureWithItsPose) {
  Intake intake = Make();
  intake.OnPhase1(Packet(3, 1), core::MonoTime::FromNs(77));
  ASSERT_EQ(items_.size(), 1U);
  const gis::PanoramaRecord* p = items_[0].picture();
  ASSERT_NE(p, nullptr);
  EXPECT_EQ(p->robot, "rover-1");
  EXPECT_EQ(p->epoch, 3);
  EXPECT_EQ(p->stage, gis::PictureStage::kFull);
  EXPECT_EQ(p->pose.time, kStart + core::Seconds(3));
  EXPECT_EQ(p->pose.rtk, core::RtkState::kFixed);
  EXPECT_NEAR(p->pose.position_sd_enu_m[0], 0.01, 1e-12);
  EXPECT_NEAR(p->pose.position_sd_enu_m[1], 0.02, 1e-12);
  EXPECT_TRUE(std::isnan(p->pose.position_sd_enu_m[2])) << "a negative variance is unknown";
  EXPECT_EQ(items_[0].received.ns(), 77);
}

TEST_F(IntakeTest, KeepsTheFirstPoseOfEachPeriodAndEveryExposure) {
  Intake intake = Make(2.0);
  intake.OnPhase1(Packet(1, 0), {});
  for (int i = 0; i < 75 * 3; ++i) intake.OnPose(RobotPose(0.001 + i / 75.0), false, {});
  intake.OnPose(RobotPose(1.25), true, {});
  const auto poses = Poses();
  ASSERT_EQ(poses.size(), 6U) << "of six intervals the first is not known to be whole";
  EXPECT_GE(poses[0].pose.time, kStart + core::Milliseconds(500));
  for (std::size_t i = 0; i < 5; ++i) {
    const double into_period_s = std::fmod(core::ToSeconds(poses[i].pose.time - kStart), 0.5);
    EXPECT_LT(into_period_s, 1 / 75.0) << i;
  }
  EXPECT_TRUE(poses[5].at_exposure);
  EXPECT_EQ(intake.stats().poses, 226);
}

TEST_F(IntakeTest, RobotsOnOneBusDoNotMix) {
  Intake intake = Make();
  for (int i = 0; i < 300; ++i) {
    intake.OnPose(RobotPose(i / 100.0, "rover-1"), false, {});
    intake.OnPose(RobotPose(i / 100.0 + 0.005, "rover-2"), false, {});
  }
  std::map<std::string, int> kept;
  for (const auto& pose : Poses()) ++kept[pose.robot];
  EXPECT_EQ(kept, (std::map<std::string, int>{{"rover-1", 2}, {"rover-2", 2}}));
}

TEST_F(IntakeTest, PosesWithoutAnyPictureAreKept) {
  Intake intake = Make();
  intake.OnPose(RobotPose(0, "digger", "night-1"), true, {});
  ASSERT_EQ(Poses().size(), 1U);
  EXPECT_EQ(Poses()[0].robot, "digger");
  EXPECT_EQ(Poses()[0].mission, "night-1");
}

TEST_F(IntakeTest, APoseOfNobodyIsRefused) {
  Intake intake = Make();
  intake.OnPose(RobotPose(0, ""), true, {});
  intake.OnPose(RobotPose(0, std::string("a\0b", 3)), true, {});
  intake.OnPose(RobotPose(0, "rover-1", std::string(5000, 'm')), true, {});
  EXPECT_EQ(intake.stats().refused, 3);
  EXPECT_TRUE(items_.empty());
}

TEST_F(IntakeTest, HolesInTheNumberingAreMissingPictures) {
  Intake intake = Make();
  for (const int epoch : {3, 4, 7, 5}) intake.OnPhase1(Packet(epoch, 1), {});
  EXPECT_EQ(intake.missing_pictures(), 1) << "6 never came";
  EXPECT_EQ(intake.late_pictures(), 1) << "5 came after 7";
}

TEST_F(IntakeTest, AnInvalidPoseIsCountedAndAPictureWithoutPlaceIsKept) {
  Intake intake = Make();
  robot_pose_t pose = RobotPose(1);
  pose.pose.valid = false;
  intake.OnPose(pose, false, {});
  phase1_t packet = Packet(1, 1);
  packet.pose.valid = false;
  packet.pose.lat_deg = std::nan("");
  intake.OnPhase1(packet, {});
  EXPECT_EQ(intake.stats().poses_invalid, 1);
  ASSERT_EQ(items_.size(), 1U);
  EXPECT_FALSE(items_[0].picture()->has_position);
}

TEST_F(IntakeTest, HostilePacketsAreCountedAndNothingElse) {
  Intake intake = Make();
  const std::vector<std::function<void(phase1_t&)>> spoils{
      [](auto& m) { m.pose.lat_deg = 91; },
      [](auto& m) { m.pose.gps_ns = std::numeric_limits<std::int64_t>::min(); },
      [](auto& m) { m.stage = -1; },
      [](auto& m) { m.reason = 100; },
      [](auto& m) { m.epoch = std::numeric_limits<std::int64_t>::max(); },
      [](auto& m) { m.epoch = -5; },
      [](auto& m) { m.robot = std::string("a\0b", 3); },
      [](auto& m) { m.mission.assign(5000, 'm'); },
      [](auto& m) { m.jpeg.clear(); },
      [](auto& m) { m.jpeg.resize(200'000); },
      [](auto& m) { m.jpeg.pop_back(); },
      [](auto& m) { m.width = -512; },
      [](auto& m) { m.pose.rtk_state = -1; },
  };
  std::int64_t refused = 0;
  for (const auto& spoil : spoils) {
    phase1_t packet = Packet(1, 1);
    spoil(packet);
    intake.OnPhase1(packet, {});
    EXPECT_EQ(intake.stats().refused, ++refused);
  }
  EXPECT_TRUE(items_.empty());
  EXPECT_THAT(intake.stats().last_refusal, HasSubstr("PHASE1: "));
}

TEST_F(IntakeTest, APoseFromTheFarFutureDoesNotSilenceTheOnesAfterIt) {
  Intake intake = Make();
  intake.OnPhase1(Packet(1, 0), {});
  robot_pose_t far = RobotPose(1);
  far.pose.gps_ns += 5'000'000'000'000'000'000;  // 158 years
  intake.OnPose(far, false, {});
  for (const double t : {1.0, 2.0, 3.0}) intake.OnPose(RobotPose(t), false, {});
  EXPECT_EQ(Poses().size(), 2U) << "those at 2 and 3 s; that at 1 s is the first after a jump";
}

TEST_F(IntakeTest, WhoJoinsInTheMiddleKeepsOnlyWhatOthersKeep) {
  Intake whole = Make();
  const auto hear = [](Intake& intake, int from) {
    intake.OnPhase1(Packet(1, 0), {});
    for (int i = from; i < 400; ++i) intake.OnPose(RobotPose(i / 75.0), false, {});
  };
  hear(whole, 0);
  std::vector<core::GpsTime> all;
  for (const auto& pose : Poses()) all.push_back(pose.pose.time);
  ASSERT_EQ(all.size(), 5U);
  for (const int from : {1, 74, 75, 76, 140}) {
    items_.clear();
    Intake late = Make();
    hear(late, from);
    for (const auto& pose : Poses()) EXPECT_THAT(all, ::testing::Contains(pose.pose.time)) << from;
  }
}

TEST_F(IntakeTest, EventTextIsMadeClean) {
  Intake intake = Make();
  event_t event;
  event.robot = "rover-1";
  event.mission = "20261122T062505Z";
  event.mono_ns = 5;
  event.gps_ns = 0;
  event.severity = 2;
  event.name = "gps.unplugged";
  event.text = "read:\x1b[2J\ngone";
  event.suppressed = 1;
  intake.OnEvent(event, {});
  ASSERT_EQ(items_.size(), 1U);
  EXPECT_EQ(std::get<gis::EventRecord>(items_[0].record).text, "read:?[2J?gone");
  EXPECT_EQ(std::get<gis::EventRecord>(items_[0].record).robot, "rover-1");
  event.robot.clear();
  intake.OnEvent(event, {});
  EXPECT_EQ(items_.size(), 1U) << "an event of nobody";
}

TEST_F(IntakeTest, LossesTheRobotCountsAreReported) {
  Intake intake = Make();
  counters_t counters;
  counters.name = {"log.dropped", "gps.bytes", "link.tx.expired", "bus.dropped"};
  counters.value = {3, 1000, 1, 0};
  intake.OnCounters(counters);
  EXPECT_EQ(intake.RobotLosses(), "link.tx.expired 1, log.dropped 3");
}

}  // namespace
}  // namespace kawara::station
