#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "onboard/config.hpp"
#include "onboard/core_sink.hpp"
#include "onboard/frame_table.hpp"

namespace kawara::onboard {

/// Turns what the core says into LCM messages: the one place that knows which message goes on which
/// channel. Serves the live pump (behind the real-time ring) and replay (directly) alike. Not
/// real-time: it allocates. Trigger, Write and SetBaud are not messages; this class ignores them.
class MessageSink : public CoreSink {
 public:
  enum class Reach {
    kLogOnly,  ///< raw inputs and frames: too much for the bus, and nobody's business there
    kBusAndLog,
  };
  using Emit = std::function<void(std::string_view channel, std::span<const std::uint8_t> bytes,
                                  Reach reach)>;

  /// `frames` holds the pixels of FrameInput.slot; poses and events go out under the robot's name.
  MessageSink(RobotConfig robot, const FrameTable& frames, Emit emit)
      : robot_(std::move(robot)), frames_(frames), emit_(std::move(emit)) {}

  void OnInput(const Input& input) override;
  void OnFrame(const FrameInput& frame, bool selected) override;
  void OnFix(const core::GnssFix& fix) override;
  void OnAhrs(const core::AhrsSample& sample, core::GpsTime sampled) override;
  void OnPose(const core::Pose& pose) override;
  void OnNavigation(const estimation::NavigationReport& report) override;
  void OnClock(const estimation::ClockStatus& clock) override;
  void OnEvent(const core::Event& event, core::GpsTime time) override;
  void OnNote(core::MonoTime mono, const EventNote& note, core::GpsTime time) override;
  void OnExposurePose(const ExposurePose& pose) override;
  void OnPicture(const PictureOrder& /*order*/) override {}
  void Trigger(std::uint32_t /*sequence*/) override {}
  void Write(PortId /*port*/, std::span<const std::uint8_t> /*bytes*/) override {}
  void SetBaud(PortId /*port*/, int /*baud_bps*/) override {}

 private:
  template <class T>
  void Send(std::string_view channel, const T& message, Reach reach);

  void SendPose(std::string_view channel, const core::Pose& pose);
  void SendEvent(core::MonoTime mono, const EventNote& note, std::int64_t suppressed,
                 core::GpsTime time);

  RobotConfig robot_;
  const FrameTable& frames_;
  Emit emit_;
};

}  // namespace kawara::onboard
