#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/unit/onboard/small_robot.hpp"

/// The receiver's event input, seen through the whole core.
namespace kawara::onboard {
namespace {

/// Exposures begin so much after the trigger, of which the camera's stamps (at the trigger, in this
/// world) know nothing.
constexpr core::Duration kLead = core::Nanoseconds(7'312'300);

OnboardConfig MarkedConfig(const char* wired) {
  OnboardConfig config = Config();
  config.camera.event_mark = wired;
  return config;
}

int Told(const Recording& sink, const std::string& event) {
  return static_cast<int>(
      std::count_if(sink.messages.begin(), sink.messages.end(), [&](const std::string& message) {
        return message.starts_with("EVENT") && message.find(event) != std::string::npos;
      }));
}

TEST(PictureMarks, TheReceiversTimeOfTheShutterIsThePicturesTime) {
  World<Recording> world(MarkedConfig("exposure"));
  std::set<core::GpsTime> marks;
  world.mark = [&](std::int64_t ms) { return *marks.insert(Gps(ms) + kLead).first; };
  world.Run(0, 25'000);
  ASSERT_GE(world.sink.poses.size(), 18U);
  for (const ExposurePose& pose : world.sink.poses) {
    const bool marked = std::any_of(marks.begin(), marks.end(), [&](core::GpsTime mark) {
      return std::chrono::abs(mark - pose.camera.time) <= core::Nanoseconds(200);
    });
    EXPECT_TRUE(marked);
    EXPECT_TRUE(pose.camera.valid);
  }
  // What the configuration ought to say, learnt from them.
  EXPECT_EQ(Told(world.sink, "camera.lead"), 1);
}

TEST(PictureMarks, OfATriggerTheyNeedTheLead) {
  OnboardConfig config = MarkedConfig("trigger");
  config.camera.trigger_lead_s = 0.005;
  World<Recording> world(config);
  std::set<core::GpsTime> marks;
  world.mark = [&](std::int64_t ms) {
    return *marks.insert(Gps(ms) + core::Milliseconds(1)).first;
  };
  world.Run(0, 10'000);
  ASSERT_GE(world.sink.poses.size(), 5U);
  for (const ExposurePose& pose : world.sink.poses) {
    EXPECT_TRUE(std::any_of(marks.begin(), marks.end(), [&](core::GpsTime mark) {
      const core::Duration error = pose.camera.time - (mark + core::Milliseconds(5));
      return std::chrono::abs(error) <= core::Nanoseconds(200);
    }));
  }
}

TEST(PictureMarks, OneThatIsLostShiftsNothing) {
  World<Recording> world(MarkedConfig("exposure"));
  int shots = 0, lost = 0;
  world.mark = [&](std::int64_t ms) -> std::optional<core::GpsTime> {
    if (++shots % 3 == 0) {
      ++lost;
      return std::nullopt;
    }
    return Gps(ms) + kLead;
  };
  world.Run(0, 25'000);
  ASSERT_GE(world.sink.poses.size(), 18U);
  int off = 0;
  for (const ExposurePose& pose : world.sink.poses) {
    // This world fires on a grid of 5 ms; a mark of another epoch would lie a second off.
    const std::int64_t past = (pose.camera.time - Gps(0)).count() % core::Milliseconds(5).count();
    if (std::chrono::abs(core::Nanoseconds(past) - kLead % core::Milliseconds(5)) >
        core::Nanoseconds(200))
      ++off;
  }
  EXPECT_NEAR(off, lost, 1);
  EXPECT_EQ(Told(world.sink, "camera.no_mark"), 0);
}

TEST(PictureMarks, WithoutThemTheCamerasOwnStampsServeAndOneWordIsSaid) {
  World<Recording> unwired(MarkedConfig("exposure")), plain;
  for (auto* world : {&unwired, &plain}) world->Run(0, 20'000);
  ASSERT_EQ(unwired.sink.poses.size(), plain.sink.poses.size());
  for (std::size_t i = 0; i < plain.sink.poses.size(); ++i) {
    EXPECT_EQ(unwired.sink.poses[i].camera.time, plain.sink.poses[i].camera.time);
  }
  EXPECT_EQ(Told(unwired.sink, "camera.no_mark"), 1);
  EXPECT_EQ(Told(plain.sink, "camera.no_mark"), 0);
}

}  // namespace
}  // namespace kawara::onboard
