#include "onboard/robot_core.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/support/counting_allocator.hpp"
#include "tests/unit/onboard/small_robot.hpp"

namespace kawara::onboard {
namespace {

TEST(RobotCore, PicturesAtEpochsWithTheirPoses) {
  World<Recording> world;
  world.Run(0, 20'000);
  EXPECT_GE(world.sink.pictures.size(), 15U);
  ASSERT_EQ(world.sink.poses.size(), world.sink.pictures.size());
  for (const ExposurePose& pose : world.sink.poses) {
    EXPECT_TRUE(pose.camera.valid);
    EXPECT_NEAR(pose.camera.attitude.yaw_rad * core::kDegFromRad, 90.0, 0.5);
    // At whole GPS seconds (epochs at .00 .25 .50 .75, every fourth), on the 5 ms grid of this
    // world.
    EXPECT_LT(std::abs(std::remainder(
                  core::ToSeconds(core::Duration(pose.camera.time.ns() % 1'000'000'000'000)), 1.0)),
              0.012);
  }
  EXPECT_GT(world.sink.count["POSE"], 1500);
  EXPECT_EQ(world.sink.count["GNSS"], 80);
}

TEST(RobotCore, TheSameInputsGiveTheSameMessages) {
  World<Recording> one, two;
  for (auto* world : {&one, &two}) {
    world->SystemClock(0, core::FromCivil({2026, 6, 20, 12, 0, 0}));
    world->Run(0, 8'000);
    world->Give(InputKind::kCommand, 8'000, "picture ");
    world->Run(8'000, 12'000, /*gps=*/false);
    world->Run(12'000, 16'000);
  }
  EXPECT_EQ(one.sink.messages, two.sink.messages);
  EXPECT_EQ(one.sink.triggers, two.sink.triggers);
}

TEST(RobotCore, ASystemClockSteppedByAnHourChangesNoPose) {
  World<Recording> steady, stepped;
  for (auto* world : {&steady, &stepped}) {
    world->SystemClock(0, core::FromCivil({2026, 6, 20, 12, 0, 0}));
    world->Run(0, 8'000);
    if (world == &stepped) world->SystemClock(8'000, core::FromCivil({2026, 6, 20, 13, 0, 8}));
    world->Run(8'000, 16'000);
  }
  ASSERT_EQ(steady.sink.poses.size(), stepped.sink.poses.size());
  for (std::size_t i = 0; i < steady.sink.poses.size(); ++i) {
    EXPECT_EQ(steady.sink.poses[i].camera.time, stepped.sink.poses[i].camera.time);
  }
}

TEST(RobotCore, WithoutGpsThePicturesBearTheComputersTimeAndNoPlace) {
  World<Recording> world;
  world.SystemClock(0, core::FromCivil({2026, 6, 20, 12, 0, 0}));
  world.Run(0, 12'000, /*gps=*/false);
  ASSERT_GE(world.sink.poses.size(), 4U);
  for (const ExposurePose& pose : world.sink.poses) {
    EXPECT_FALSE(pose.camera.valid);
    EXPECT_EQ(pose.reason, PictureReason::kFreeRunning);
    const double since =
        core::ToSeconds(core::ToUtc(pose.camera.time) - core::FromCivil({2026, 6, 20, 12, 0, 0}));
    EXPECT_GT(since, 4.9);
    EXPECT_LT(since, 12.5);
  }
}

/// Seconds until time rests on the pulses.
int SecondsToLock(bool named) {
  OnboardConfig config = Config();
  config.gps.pps.device = "pps";
  World<Recording> world(config);
  for (int s = 0; s < 20; ++s) {
    const auto pulse = Pack(static_cast<std::uint32_t>(s + 1));
    world.Give(InputKind::kPulse, s * 1000, {reinterpret_cast<const char*>(pulse.data()), 4});
    world.Run(s * 1000, s * 1000 + 30);
    if (named) world.Give(InputKind::kGpsBytes, s * 1000 + 30, TimeTag(Gps(s * 1000), "PTT"));
    world.Run(s * 1000 + 30, s * 1000 + 1000);
    for (const std::string& message : world.sink.messages) {
      if (message.find("clock.pps") != std::string::npos) return s;
    }
  }
  return 20;
}

TEST(RobotCore, PulsesThatTheReceiverNamesAreBelievedSooner) {
  const int unnamed = SecondsToLock(false);
  EXPECT_LT(unnamed, 15);
  EXPECT_LT(SecondsToLock(true), unnamed);
}

TEST(RobotCore, CorrectionsReachTheReceiverAsWholeMessages) {
  OnboardConfig config = Config();
  config.corrections.source = "serial";
  World<Recording> world(config);
  // The standard's example of a 1005 message, in two pieces with garbage before it.
  const std::string frame(
      "\xD3\x00\x13\x3E\xD7\xD3\x02\x02\x98\x0E\xDE\xEF\x34\xB4\xBD\x62\xAC\x09\x41\x98\x6F\x33\x36"
      "\x0B\x98",
      25);
  world.Give(InputKind::kCorrectionBytes, 10, "noise" + frame.substr(0, 10));
  EXPECT_TRUE(world.sink.written.empty());
  world.Give(InputKind::kCorrectionBytes, 20, frame.substr(10));
  ASSERT_EQ(world.sink.written.size(), 1U);
  EXPECT_EQ(world.sink.written[0], frame);
}

TEST(RobotCore, UnknownCommandsAndForeignBytesAreToldNotObeyed) {
  World<Recording> world;
  world.Run(0, 3'000);
  world.Give(InputKind::kCommand, 3'000, "explode now");
  world.Give(InputKind::kPort, 3'001, "garbage");
  world.Give(InputKind::kSystemClock, 3'002, "123");
  world.Run(3'005, 4'000);
  bool told = false;
  for (const std::string& message : world.sink.messages) {
    told |= message.find("unknown command: explode") != std::string::npos;
  }
  EXPECT_TRUE(told);
}

TEST(RobotCore, NothingIsAllocatedOnTheRealTimePath) {
  World<Deaf> world;
  world.Run(0, 5'000);
  EXPECT_EQ(testing::CountAllocations([&] {
              world.Run(5'000, 15'000);
              world.Run(15'000, 22'000, /*gps=*/false);
            }),
            0U);
  EXPECT_GT(world.sink.fixes, 50);
  EXPECT_GT(world.sink.poses, 900);
  EXPECT_GT(world.sink.pictures, 8);
}

}  // namespace
}  // namespace kawara::onboard
