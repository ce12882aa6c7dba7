#include "onboard/robot_core.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "onboard/message_sink.hpp"
#include "tests/support/counting_allocator.hpp"

namespace kawara::onboard {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kStart = 7'000'000 * kMs;

core::MonoTime Mono(std::int64_t ms) { return core::MonoTime::FromNs(kStart + ms * kMs); }

std::string Sentence(const std::string& body) {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  char end[8];
  std::snprintf(end, sizeof(end), "*%02X\r\n", sum);
  return "$" + body + end;
}

/// GGA and RMC of an RTK receiver that stands still; epoch at `ms` after 12:00:00 UTC.
std::string Burst(std::int64_t ms) {
  char time[16];
  std::snprintf(time, sizeof(time), "12%02d%02d.%02d", static_cast<int>(ms / 60000 % 60),
                static_cast<int>(ms / 1000 % 60), static_cast<int>(ms / 10 % 100));
  return Sentence("GPGGA," + std::string(time) +
                  ",3510.0000000,N,13658.0000000,E,4,09,0.9,50.000,M,37.500,M,1.0,0001") +
         Sentence("GPRMC," + std::string(time) +
                  ",A,3510.0000000,N,13658.0000000,E,0.00,090.0,200626,,,A");
}

/// A level AHRS400 angle packet, heading 90 degrees, at rest.
std::array<std::uint8_t, 30> AhrsPacket(std::int64_t ms) {
  std::array<std::uint8_t, 30> packet{};
  packet[0] = 0xFF;
  const auto put = [&](std::size_t word, int value) {
    packet[1 + 2 * word] = static_cast<std::uint8_t>((value >> 8) & 0xFF);
    packet[2 + 2 * word] = static_cast<std::uint8_t>(value & 0xFF);
  };
  put(2, 16384);                                          // heading 90 deg
  put(8, static_cast<int>(std::lround(-32768.0 / 3.0)));  // -1 g of 3 g full scale
  put(12, 1536);                                          // 22 deg C
  put(13, static_cast<int>(65535 - (ms * 1'000'000 / 790) % 65536));
  unsigned sum = 0;
  for (std::size_t i = 1; i < 29; ++i) sum += packet[i];
  packet[29] = static_cast<std::uint8_t>(sum);
  return packet;
}

OnboardConfig Config() {
  OnboardConfig config;
  config.gps.device = "gps";
  config.gps.profile = "nmea";
  config.gps.configure = false;
  config.gps.latency_s = 0.05;
  config.ahrs.device = "ahrs";
  config.camera.path = "camera";
  config.schedule.rule.every_epochs = 4;
  return config;
}

/// Everything the core says, as messages; triggers and writes as text.
class Recording : public MessageSink {
 public:
  Recording()
      : MessageSink({"tester", "mission"}, frames_,
                    [this](std::string_view channel, std::span<const std::uint8_t> bytes, Reach) {
                      messages.push_back(std::string(channel) + " " +
                                         std::string(bytes.begin(), bytes.end()));
                      ++count[std::string(channel)];
                    }) {}
  void Trigger(std::uint32_t sequence) override { triggers.push_back(sequence); }
  void Write(PortId port, std::span<const std::uint8_t> bytes) override {
    if (port != PortId::kGps) return;
    written.emplace_back(bytes.begin(), bytes.end());
  }
  void OnPicture(const PictureOrder& order) override { pictures.push_back(order.epoch); }
  void OnExposurePose(const ExposurePose& pose) override {
    MessageSink::OnExposurePose(pose);
    poses.push_back(pose);
  }

  std::vector<std::string> messages;
  std::map<std::string, int> count;
  std::vector<std::uint32_t> triggers;
  std::vector<std::string> written;
  std::vector<std::int64_t> pictures;
  std::vector<ExposurePose> poses;

 private:
  FrameTable frames_;
};

/// Says nothing and costs nothing, for counting allocations.
class Deaf : public CoreSink {
 public:
  void OnInput(const Input&) override {}
  void OnFrame(const FrameInput&, bool) override {}
  void OnFix(const core::GnssFix&) override { ++fixes; }
  void OnAhrs(const core::AhrsSample&, core::GpsTime) override {}
  void OnPose(const core::Pose&) override { ++poses; }
  void OnNavigation(const estimation::NavigationReport&) override {}
  void OnClock(const estimation::ClockStatus&) override {}
  void OnEvent(const core::Event&, core::GpsTime) override {}
  void OnNote(core::MonoTime, const EventNote&, core::GpsTime) override {}
  void OnPicture(const PictureOrder&) override { ++pictures; }
  void OnExposurePose(const ExposurePose&) override {}
  void Trigger(std::uint32_t sequence) override { last_trigger = sequence; }
  void Write(PortId, std::span<const std::uint8_t>) override {}
  void SetBaud(PortId, int) override {}
  int fixes = 0, poses = 0, pictures = 0;
  std::uint32_t last_trigger = 0;
};

/// The world around the core: instruments at their rates, a camera that answers each trigger 20 ms
/// later.
template <class Sink>
class World {
 public:
  explicit World(const OnboardConfig& config = Config()) : core_(config, counters, sink) {
    for (std::int64_t ms = 0; ms < 30'000; ms += 250) bursts_.push_back(Burst(ms));
    Give(InputKind::kPort, 0,
         Pack(PortNote{PortId::kGps, true, true, core::Severity::kInfo, ""}).view());
    Give(InputKind::kPort, 0,
         Pack(PortNote{PortId::kAhrs, true, true, core::Severity::kInfo, ""}).view());
  }

  void Run(std::int64_t from_ms, std::int64_t to_ms, bool gps = true) {
    for (std::int64_t t = from_ms; t < to_ms; t += 5) {
      if (t % 10 == 0) {
        const auto packet = AhrsPacket(t);
        core_.OnInput({InputKind::kAhrsBytes, ++sequence_, Mono(t), packet});
      }
      // Every 250 ms an epoch; its sentences begin 50 ms after it.
      if (gps && t >= 50 && (t - 50) % 250 == 0) {
        Give(InputKind::kGpsBytes, t, bursts_[static_cast<std::size_t>((t - 50) / 250)]);
      }
      Give(InputKind::kTick, t, "");
      AnswerTrigger(t);
    }
  }
  void Give(InputKind kind, std::int64_t ms, std::string_view bytes) {
    core_.OnInput({kind, ++sequence_, Mono(ms), BytesOf(bytes)});
  }
  void SystemClock(std::int64_t ms, core::UtcTime utc) {
    const std::int64_t ns = utc.ns();
    char bytes[8];
    std::memcpy(bytes, &ns, 8);
    Give(InputKind::kSystemClock, ms, {bytes, 8});
  }

  Sink sink;
  core::Counters counters;

 private:
  std::uint32_t LastTrigger() const {
    if constexpr (requires { sink.last_trigger; }) {
      return sink.last_trigger;
    } else {
      return sink.triggers.empty() ? 0 : sink.triggers.back();
    }
  }
  void AnswerTrigger(std::int64_t t) {
    if (LastTrigger() != answered_ && !exposed_at_) {
      answered_ = LastTrigger();
      exposed_at_ = t;
    }
    if (!exposed_at_ || t < *exposed_at_ + 20) return;
    FrameInput frame;
    frame.sequence = ++sequence_;
    frame.frame_sequence = answered_;
    frame.trigger_sequence = answered_;
    frame.exposure_start = Mono(*exposed_at_);
    frame.arrival = Mono(t);
    exposed_at_.reset();
    core_.OnFrame(frame);
    Give(InputKind::kPictureDone, t, "");
  }

  RobotCore core_;
  std::vector<std::string> bursts_;
  std::int64_t sequence_ = 0;
  std::uint32_t answered_ = 0;
  std::optional<std::int64_t> exposed_at_;
};

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
