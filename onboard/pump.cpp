#include "onboard/pump.hpp"

#include <poll.h>

#include <array>
#include <chrono>
#include <cstring>
#include <kawara/command_t.hpp>
#include <kawara/corrections_t.hpp>
#include <utility>

#include "comms/typed_bus.hpp"
#include "core/check.hpp"
#include "onboard/counters_message.hpp"
#include "onboard/realtime.hpp"

namespace kawara::onboard {
namespace {

constexpr core::Duration kSystemClockPeriod = core::Seconds(60);
constexpr std::size_t kMaxCommandBytes = 256;
constexpr std::size_t kMaxCorrectionBytes = 4096;

}  // namespace

/// Messages for everybody, orders for the worker, positions for the caster.
class Pump::Sink final : public MessageSink {
 public:
  Sink(const RobotConfig& robot, const Parts& parts, Emit emit)
      : MessageSink(robot, parts.frames, std::move(emit)), parts_(parts) {}

  void OnFrame(const FrameInput& frame, bool selected) override {
    // Of a camera that runs freely most frames are between triggers: their pixels would fill the
    // disk for nothing. That they came is logged all the same, or the log could not be replayed.
    FrameInput logged = frame;
    if (!selected && parts_.camera_runs_freely) logged.slot = FrameTable::kSlots;
    MessageSink::OnFrame(logged, selected);
    if (!selected || parts_.pictures == nullptr) parts_.frames.Release(frame.slot);
  }
  void OnFix(const core::GnssFix& fix) override {
    MessageSink::OnFix(fix);
    parts_.corrections.OnFix(fix);
  }
  void OnClock(const estimation::ClockStatus& clock) override {
    MessageSink::OnClock(clock);
    if (parts_.system_clock != nullptr) parts_.system_clock->OnClock(clock);
  }
  void OnPicture(const PictureOrder& order) override {
    if (parts_.pictures != nullptr) parts_.pictures->Add(order);
  }
  void OnExposurePose(const ExposurePose& pose) override {
    MessageSink::OnExposurePose(pose);
    if (parts_.pictures != nullptr) parts_.pictures->Add(pose);
  }

 private:
  const Parts& parts_;
};

Pump::Pump(const Parts& parts, RobotConfig robot, bool corrections_from_bus)
    : parts_(parts), robot_(std::move(robot)) {
  Subscribe(corrections_from_bus);
}

Pump::~Pump() { Stop(); }

void Pump::Start() {
  thread_ = std::thread([this] { Run(); });
}

void Pump::Stop() {
  stopping_.store(true, std::memory_order_relaxed);
  if (thread_.joinable()) thread_.join();
}

void Pump::Subscribe(bool corrections_from_bus) {
  auto ok = comms::Subscribe<command_t>(
      parts_.bus, "COMMAND", [this](const command_t& command, const comms::MessageMeta&) {
        // The station repeats a command until it sees its effect: the number tells a new one.
        if (command.robot != robot_.name || command.sequence == last_command_) return;
        last_command_ = command.sequence;
        std::string text = command.verb + " " + command.argument;
        text.resize(std::min(text.size(), kMaxCommandBytes));
        parts_.inbox.Post(InputKind::kCommand, core::MonoNow(), BytesOf(text));
      });
  CORE_CHECK(ok.has_value());  // the channel name is a constant
  if (!corrections_from_bus) return;
  ok = comms::Subscribe<corrections_t>(
      parts_.bus, "CORRECTIONS",
      [this](const corrections_t& corrections, const comms::MessageMeta&) {
        if (corrections.data.size() > kMaxCorrectionBytes) return;
        parts_.inbox.Post(InputKind::kCorrectionBytes, core::MonoNow(), corrections.data);
      });
  CORE_CHECK(ok.has_value());
}

void Pump::Run() {
  BecomeBackground("pump", -5);
  while (!stopping_.load(std::memory_order_relaxed)) {
    heart_.Beat();
    std::array<pollfd, 2> fds{{{parts_.output.fd(), POLLIN, 0}, {parts_.bus.fd(), POLLIN, 0}}};
    (void)poll(fds.data(), fds.size(), 100);
    const core::MonoTime now = core::MonoNow();
    if (now >= next_system_clock_) PostSystemClock(now);
    Deliver();
    if ((fds[1].revents & POLLIN) != 0) (void)parts_.bus.HandleFor(core::Duration(0));
    if (now >= next_second_) EverySecond(now);
  }
  Deliver();
  EverySecond(core::MonoNow());
}

void Pump::Deliver() {
  Sink sink(robot_, parts_,
            [this](std::string_view channel, std::span<const std::uint8_t> bytes,
                   MessageSink::Reach reach) { parts_.outlet.Send(channel, bytes, reach); });
  parts_.output.Acknowledge();
  while (parts_.output.TryDeliver(sink)) {
  }
}

void Pump::PostSystemClock(core::MonoTime now) {
  next_system_clock_ = now + kSystemClockPeriod;
  const std::int64_t utc_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(
                                  std::chrono::system_clock::now().time_since_epoch())
                                  .count();
  std::array<std::uint8_t, sizeof(utc_ns)> bytes{};
  std::memcpy(bytes.data(), &utc_ns, sizeof(utc_ns));
  parts_.inbox.Post(InputKind::kSystemClock, now, bytes);
}

void Pump::EverySecond(core::MonoTime now) {
  next_second_ = now + core::Seconds(1);
  parts_.outlet.Send("COUNTERS", CountersMessage(parts_.counters, now),
                     MessageSink::Reach::kBusAndLog);
}

}  // namespace kawara::onboard
