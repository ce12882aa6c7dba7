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

TEST(PictureMarks, ThePoseIsOfTheMiddleOfTheExposureAsLongAsTheCameraTells) {
  World<Recording> world(MarkedConfig("exposure"));
  std::set<core::GpsTime> starts;
  world.mark = [&](std::int64_t ms) { return *starts.insert(Gps(ms) + kLead).first; };
  const auto shutter = [&](std::int64_t ms, core::Duration length) {
    const auto bytes = Pack(length);
    world.Give(InputKind::kShutter, ms, {reinterpret_cast<const char*>(bytes.data()), 8});
  };
  world.Run(0, 10'000);
  const std::size_t before = world.sink.poses.size();
  shutter(10'000, core::Milliseconds(8));
  shutter(10'000, core::Seconds(3000));  // nonsense is ignored
  shutter(10'000, core::Milliseconds(-8));
  world.Give(InputKind::kShutter, 10'000, "123");
  world.Run(10'000, 20'000);
  ASSERT_GE(before, 5U);
  ASSERT_GE(world.sink.poses.size(), before + 5);
  for (std::size_t i = 0; i < world.sink.poses.size(); ++i) {
    const core::Duration after_start = core::Milliseconds(i < before ? 0 : 4);
    EXPECT_TRUE(std::any_of(starts.begin(), starts.end(), [&](core::GpsTime start) {
      const core::Duration error = world.sink.poses[i].camera.time - (start + after_start);
      return std::chrono::abs(error) <= core::Nanoseconds(200);
    })) << i;
  }
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

TEST(PictureMarks, OneThatIsLostShiftsNothingAndIsSoonDoneWithout) {
  OnboardConfig config = MarkedConfig("exposure");
  config.schedule.rule.every_epochs = 1;
  World<Recording> world(config);
  int shots = 0;
  world.mark = [&](std::int64_t ms) -> std::optional<core::GpsTime> {
    if (++shots % 3 == 0) return std::nullopt;
    return Gps(ms) + kLead;
  };
  world.Run(0, 29'000);
  ASSERT_GE(world.sink.poses.size(), 80U);
  std::vector<std::size_t> off;
  for (std::size_t i = 0; i < world.sink.poses.size(); ++i) {
    // This world fires on a grid of 5 ms; the mark of another epoch would lie 250 ms off.
    const core::Duration since = world.sink.poses[i].camera.time - Gps(0);
    const core::Duration error = since % core::Milliseconds(5) - kLead % core::Milliseconds(5);
    if (std::chrono::abs(error) > core::Nanoseconds(1000)) off.push_back(i);
  }
  ASSERT_FALSE(off.empty()) << "at first the camera's stamp is all there is";
  EXPECT_LT(off.back(), 30U) << "then the camera is known";
  EXPECT_EQ(Told(world.sink, "camera.no_mark"), 0);
}

TEST(PictureMarks, WithoutThemTheCamerasOwnStampsServeAndOneWordIsSaid) {
  World<Recording> unwired(MarkedConfig("exposure")), plain;
  for (auto* world : {&unwired, &plain}) world->Run(0, 20'000);
  ASSERT_EQ(unwired.sink.poses.size(), plain.sink.poses.size());
  for (const ExposurePose& pose : unwired.sink.poses) {
    const core::Duration past = (pose.camera.time - Gps(0)) % core::Milliseconds(5);
    EXPECT_EQ(past, core::Duration(0)) << "this world's stamps lie on its grid";
  }
  EXPECT_EQ(Told(unwired.sink, "camera.no_mark"), 1);
  EXPECT_EQ(Told(plain.sink, "camera.no_mark"), 0);
}

}  // namespace
}  // namespace kawara::onboard
