#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "onboard/message_sink.hpp"
#include "onboard/robot_core.hpp"

/// A robot's core between instruments that are a few lines each.
namespace kawara::onboard {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kStart = 7'000'000 * kMs;

inline core::MonoTime Mono(std::int64_t ms) { return core::MonoTime::FromNs(kStart + ms * kMs); }

inline std::string Sentence(const std::string& body) {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  char end[8];
  std::snprintf(end, sizeof(end), "*%02X\r\n", sum);
  return "$" + body + end;
}

/// GGA and RMC of an RTK receiver that stands still; epoch at `ms` after 12:00:00 UTC.
inline std::string Burst(std::int64_t ms) {
  char time[16];
  std::snprintf(time, sizeof(time), "12%02d%02d.%02d", static_cast<int>(ms / 60000 % 60),
                static_cast<int>(ms / 1000 % 60), static_cast<int>(ms / 10 % 100));
  return Sentence("GPGGA," + std::string(time) +
                  ",3510.0000000,N,13658.0000000,E,4,09,0.9,50.000,M,37.500,M,1.0,0001") +
         Sentence("GPRMC," + std::string(time) +
                  ",A,3510.0000000,N,13658.0000000,E,0.00,090.0,200626,,,A");
}

/// The instant that Mono() gives for the same number, on the GPS scale.
inline core::GpsTime Gps(std::int64_t ms) {
  return core::ToGps(core::FromCivil({2026, 6, 20, 12, 0, 0})) + core::Milliseconds(ms);
}

/// $PASHR,TTT of an event at that instant, to 100 ns as the receiver prints it; or PTT of a pulse.
inline std::string TimeTag(core::GpsTime event, const char* kind = "TTT") {
  const std::int64_t tick = core::ToWeek(event).time_of_week.count() / 100;
  const std::int64_t second = tick / 10'000'000;
  char text[48];
  std::snprintf(text, sizeof(text), "PASHR,%s,%d,%02d:%02d:%02d.%07d", kind,
                static_cast<int>(second / 86400 + 1), static_cast<int>(second / 3600 % 24),
                static_cast<int>(second / 60 % 60), static_cast<int>(second % 60),
                static_cast<int>(tick % 10'000'000));
  return Sentence(text);
}

/// A level AHRS400 angle packet, heading 90 degrees, at rest.
inline std::array<std::uint8_t, 30> AhrsPacket(std::int64_t ms) {
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

inline OnboardConfig Config() {
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

  /// Of a trigger fired at `ms`: what the receiver says of the shutter, its instant on the GPS
  /// scale; empty: nothing.
  std::function<std::optional<core::GpsTime>(std::int64_t ms)> mark;

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
    if (const auto seen = mark ? mark(*exposed_at_) : std::nullopt) {
      Give(InputKind::kGpsBytes, t, TimeTag(*seen));
    }
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

}  // namespace kawara::onboard
