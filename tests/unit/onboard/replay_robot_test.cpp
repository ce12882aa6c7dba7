#include "onboard/replay_robot.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <kawara/event_t.hpp>
#include <string>
#include <vector>

#include "comms/codec.hpp"
#include "comms/event_log_writer.hpp"
#include "comms/recorder.hpp"
#include "onboard/frame_table.hpp"
#include "onboard/message_sink.hpp"
#include "onboard/robot_core.hpp"
#include "tests/support/test_folder.hpp"

namespace kawara::onboard {
namespace {

using Blob = std::vector<std::uint8_t>;

struct Message {
  std::string channel;
  Blob bytes;
  bool operator==(const Message&) const = default;
};

OnboardConfig NavigationOnly() {
  OnboardConfig config;
  config.robot = {"tester", "mission"};
  config.gps.device = "gps";
  config.gps.profile = "nmea";
  config.gps.configure = false;
  config.ahrs.device = "ahrs";
  config.camera.source = "none";
  return config;
}

/// A short mission with things to tell, its log, and what it said live.
class ReplayRobotTest : public ::testing::Test {
 protected:
  ReplayRobotTest()
      : log_(comms::EventLogWriter::Create(folder_ / "log", {.fdatasync = false}).value()) {}

  void Log(std::string_view channel, std::span<const std::uint8_t> bytes) {
    EXPECT_TRUE(log_.Append(1'700'000'000'000'000 + ++entries_, channel, bytes, {}));
  }
  void Say(std::string_view channel, std::span<const std::uint8_t> bytes) {
    Log(channel, bytes);
    said_.push_back({std::string(channel), {bytes.begin(), bytes.end()}});
  }
  void Give(InputKind kind, std::string_view bytes) {
    ++sequence_;
    core_.OnInput(
        {kind, sequence_, core::MonoTime::FromNs(sequence_ * 400'000'000), BytesOf(bytes)});
  }
  void SayAsRecorder(const std::string& name) {
    const comms::RecorderEvent event{.robot = "tester",
                                     .mission = "mission",
                                     .mono = core::MonoTime::FromNs(sequence_ * 400'000'000),
                                     .severity = 1,
                                     .name = name,
                                     .text = "the disk took 700 ms for one round of writing"};
    Say("EVENT", comms::Encode(comms::ToMessage(event)).value());
  }
  /// Instruments that come, a command nobody knows, a complaint of another thread.
  void Drive() {
    Give(InputKind::kPort,
         Pack(PortNote{PortId::kGps, true, true, core::Severity::kInfo, "opened"}).view());
    Give(InputKind::kTick, "");
    Give(InputKind::kCommand, "explode now");
    Give(InputKind::kNote,
         Pack(EventNote{core::Severity::kWarnLow, "bus.degraded", "small buffer"}).view());
    for (int i = 0; i < 5; ++i) Give(InputKind::kTick, "");
  }
  std::vector<Message> Replay() {
    EXPECT_TRUE(log_.Close());
    auto reader = comms::EventLogReader::Open({folder_ / "log"});
    EXPECT_TRUE(reader.has_value()) << reader.error().message;
    std::vector<Message> messages;
    const auto stats = ReplayRobot::Play(
        *reader, config_,
        [&](std::string_view channel, std::span<const std::uint8_t> bytes, std::int64_t) {
          messages.push_back({std::string(channel), {bytes.begin(), bytes.end()}});
        });
    EXPECT_TRUE(stats.has_value());
    if (stats) stats_ = *stats;
    return messages;
  }
  static std::vector<std::string> EventNames(const std::vector<Message>& messages) {
    std::vector<std::string> names;
    for (const Message& message : messages) {
      if (message.channel != "EVENT") continue;
      names.push_back(comms::Decode<event_t>(message.bytes).value().name);
    }
    return names;
  }

  testing::TestFolder folder_;
  comms::EventLogWriter log_;
  std::int64_t entries_ = 0;
  std::int64_t sequence_ = 0;
  std::vector<Message> said_;  ///< live, on the bus
  ReplayStats stats_;
  const OnboardConfig config_ = NavigationOnly();
  FrameTable frames_;
  MessageSink sink_{config_.robot, frames_,
                    [this](std::string_view channel, std::span<const std::uint8_t> bytes,
                           MessageSink::Reach reach) {
                      if (reach == MessageSink::Reach::kLogOnly) return Log(channel, bytes);
                      Say(channel, bytes);
                    }};
  core::Counters counters_;
  RobotCore core_{config_, counters_, sink_};
};

// The recorder's own among them: they are in the log only, no input makes the core say them again.
TEST_F(ReplayRobotTest, EverythingSaidLiveIsSaidAgainOnceAndInItsOrder) {
  SayAsRecorder("recorder.no_reserve");
  Drive();
  SayAsRecorder("recorder.disk_slow");
  Drive();
  const std::vector<std::string> names = EventNames(said_);
  ASSERT_EQ(std::ranges::count(names, "recorder.disk_slow"), 1);
  ASSERT_EQ(std::ranges::count(names, "bus.degraded"), 2);

  const std::vector<Message> replayed = Replay();
  EXPECT_EQ(EventNames(replayed), names);
  EXPECT_EQ(replayed, said_);
  EXPECT_EQ(stats_.inputs, sequence_);
  EXPECT_EQ(stats_.events, static_cast<std::int64_t>(names.size()));
}

TEST_F(ReplayRobotTest, AnEventThatIsNoneIsPassedOver) {
  Log("EVENT", Blob{1, 2, 3});
  Drive();
  EXPECT_EQ(Replay(), said_);
}

}  // namespace
}  // namespace kawara::onboard
