// The whole robot on bytes from its ports, its bus and its camera. The first byte picks the
// configuration, then each input is one byte of kind, one of time and one of length before its
// bytes. Sentences, packets and correction frames get their checksums here, or little would come
// past the decoders. The same inputs must give the same messages: that is what replay rests on.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "core/check.hpp"
#include "drivers/ahrs400_packet.hpp"
#include "drivers/crc24q.hpp"
#include "drivers/nmea_sentence.hpp"
#include "onboard/message_sink.hpp"
#include "onboard/robot_core.hpp"

namespace {

using namespace kawara;
using namespace kawara::onboard;

using Bytes = std::span<const std::uint8_t>;

/// Order, channel and bytes of everything said, as one number (FNV-1a).
class Digest final : public MessageSink {
 public:
  Digest()
      : MessageSink({.name = "robot", .mission = "mission"}, frames_,
                    [this](std::string_view channel, Bytes bytes, Reach) {
                      Add(BytesOf(channel));
                      Add(bytes);
                    }) {}
  void OnPicture(const PictureOrder& order) override { Number(order.epoch); }
  void Trigger(std::uint32_t sequence) override { Number(sequence); }
  void Write(PortId /*port*/, Bytes bytes) override { Add(bytes); }
  void SetBaud(PortId /*port*/, int baud_bps) override {
    CORE_CHECK(baud_bps > 0);
    Number(baud_bps);
  }
  std::uint64_t value() const { return value_; }

 private:
  void Number(std::int64_t number) {
    std::array<std::uint8_t, sizeof(number)> bytes{};
    std::memcpy(bytes.data(), &number, sizeof(number));
    Add(bytes);
  }
  void Add(Bytes bytes) {
    for (const std::uint8_t byte : bytes) value_ = (value_ ^ byte) * 0x100000001b3U;
  }
  FrameTable frames_;
  std::uint64_t value_ = 0xcbf29ce484222325U;
};

OnboardConfig ConfigOf(std::uint8_t choice) {
  OnboardConfig config;
  config.gps.device = "gps";
  config.gps.configure = (choice & 1U) != 0;
  config.gps.profile = (choice & 2U) != 0 ? "ashtech-legacy" : "nmea";
  config.ahrs.device = "ahrs";
  config.ahrs.mode = (choice & 4U) != 0 ? "scaled" : "angle";
  config.camera.path = "camera";
  config.corrections.source = (choice & 8U) != 0 ? "serial" : "none";
  config.gps.pps.device = (choice & 16U) != 0 ? "pps" : "";
  config.schedule.rule.every_epochs = 2;
  return config;
}

std::vector<std::uint8_t> Sentence(Bytes body) {
  constexpr std::string_view kHex = "0123456789ABCDEF";
  const std::string text(body.begin(), body.end());
  const std::uint8_t sum = drivers::NmeaChecksum(text);
  const std::string line = "$" + text + "*" + kHex[sum >> 4] + kHex[sum & 15U] + "\r\n";
  return {line.begin(), line.end()};
}

std::vector<std::uint8_t> AhrsPacket(Bytes payload) {
  std::vector<std::uint8_t> packet{drivers::kAhrs400Header};
  packet.insert(packet.end(), payload.begin(), payload.end());
  packet.push_back(drivers::Ahrs400Checksum(payload));
  return packet;
}

std::vector<std::uint8_t> Rtcm3(Bytes payload) {
  std::vector<std::uint8_t> frame{0xD3, 0, static_cast<std::uint8_t>(payload.size())};
  frame.insert(frame.end(), payload.begin(), payload.end());
  const std::uint32_t crc = drivers::Crc24q(frame);
  for (const int shift : {16, 8, 0}) frame.push_back(static_cast<std::uint8_t>(crc >> shift));
  return frame;
}

/// 0..127 in ms, above in steps of half a second.
core::Duration StepOf(std::uint8_t time) {
  return time < 128 ? core::Milliseconds(time) : core::Milliseconds(500) * (time - 127);
}

class Robot {
 public:
  explicit Robot(std::uint8_t choice)
      : core_(std::make_unique<RobotCore>(ConfigOf(choice), counters_, sink_)) {}

  void Take(std::uint8_t kind, std::uint8_t time, Bytes bytes) {
    now_ += StepOf(time);
    switch (kind % 15) {
      case 0:
        return Give(InputKind::kGpsBytes, bytes);
      case 1:
        return Give(InputKind::kGpsBytes, Sentence(bytes));
      case 2:
        return Give(InputKind::kAhrsBytes, bytes);
      case 3:
        return Give(InputKind::kAhrsBytes, AhrsPacket(bytes));
      case 4:
        return Give(InputKind::kCorrectionBytes, bytes);
      case 5:
        return Give(InputKind::kCorrectionBytes, Rtcm3(bytes));
      case 6:
        return Give(InputKind::kPort, bytes);
      case 7:
        return Port(bytes);
      case 8:
        return Give(InputKind::kCommand, bytes);
      case 9:
        return Give(InputKind::kPictureDone, {});
      case 10:
        return Give(InputKind::kSystemClock, bytes);
      case 11:
        return Give(InputKind::kNote, bytes);
      case 12:
        return Frame(bytes);
      case 13:
        return Give(InputKind::kShutter, bytes);
      default:
        return Give(InputKind::kPulse, bytes);
    }
  }
  std::uint64_t digest() const { return sink_.value(); }

 private:
  void Give(InputKind kind, Bytes bytes) { core_->OnInput({kind, ++sequence_, now_, bytes}); }
  void Port(Bytes bytes) {
    const unsigned bits = bytes.empty() ? 1U : bytes[0];
    const auto note = Pack(PortNote{static_cast<PortId>(bits / 4 % 4), (bits & 1U) != 0,
                                    (bits & 2U) == 0, core::Severity::kInfo, "port"});
    Give(InputKind::kPort, BytesOf(note.view()));
  }
  void Frame(Bytes bytes) {
    FrameInput frame;
    frame.sequence = ++sequence_;
    frame.slot = FrameTable::kSlots;
    frame.trigger_sequence = bytes.empty() ? 0U : bytes[0];
    frame.exposure_start = now_ - StepOf(bytes.size() < 2 ? 0 : bytes[1]);
    frame.arrival = now_;
    core_->OnFrame(frame);
  }

  Digest sink_;
  core::Counters counters_;
  std::unique_ptr<RobotCore> core_;  // large
  core::MonoTime now_ = core::MonoTime::FromNs(1'000'000'000);
  std::int64_t sequence_ = 0;
};

std::uint64_t Run(Bytes bytes) {
  Robot robot(bytes[0]);
  for (Bytes rest = bytes.subspan(1); rest.size() >= 3;) {
    const std::size_t length = std::min<std::size_t>(rest[2], rest.size() - 3);
    robot.Take(rest[0], rest[1], rest.subspan(3, length));
    rest = rest.subspan(3 + length);
  }
  return robot.digest();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  CORE_CHECK(Run({data, size}) == Run({data, size}));
  return 0;
}
