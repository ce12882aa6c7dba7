#pragma once
#include <cstdint>

#include "core/counters.hpp"
#include "core/events.hpp"
#include "drivers/correction_forwarder.hpp"
#include "estimation/gps_timeline.hpp"
#include "onboard/ahrs_chain.hpp"
#include "onboard/config.hpp"
#include "onboard/core_counters.hpp"
#include "onboard/core_sink.hpp"
#include "onboard/gps_chain.hpp"
#include "onboard/navigation_chain.hpp"
#include "onboard/picture_chain.hpp"
#include "onboard/pulse_chain.hpp"

namespace kawara::onboard {

/// The robot as a state machine: inputs in their order (Input, FrameInput), everything else out
/// through a CoreSink. It reads no clock, no file, no random number, so the same inputs give the
/// same outputs, byte for byte, live or from a log at any speed. Real-time safe after construction:
/// no allocation, no lock, no exception. One thread.
class RobotCore : private GpsListener, private AhrsListener {
 public:
  /// Registers its counters in `counters` and keeps them up to date once a second.
  RobotCore(const OnboardConfig& config, core::Counters& counters, CoreSink& out);

  void OnInput(const Input& input);
  void OnFrame(const FrameInput& frame);
  /// Wants a kTick input then at the latest.
  core::MonoTime NextDeadline(core::MonoTime now) const;

 private:
  void OnGpsFix(const core::GnssFix& fix) override;
  void OnTimeTag(const drivers::AshtechTimeTag& tag, core::MonoTime arrival) override;
  void OnAhrsSample(const core::AhrsSample& sample) override;

  core::GpsTime GpsOf(core::MonoTime mono) const;  ///< not set while there is no time line
  void OnPort(const Input& input);
  void OnCommand(const Input& input);
  void OnNote(const Input& input);
  void OnPulse(const Input& input);
  void OnShutter(const Input& input);
  void OnSystemClock(const Input& input);
  void ForwardCorrections();
  void Advance(core::MonoTime now);
  void EverySecond(core::MonoTime now);
  void SendEvents();

  CoreSink& out_;
  core::Events events_;
  estimation::GpsTimeline timeline_;
  NavigationChain navigation_;
  PulseChain pulses_;
  GpsChain gps_;
  AhrsChain ahrs_;
  drivers::CorrectionForwarder corrections_;
  bool wants_corrections_;
  PictureChain pictures_;
  CoreCounters counters_;
  double configured_latency_s_;
  core::Duration latency_correction_{};  ///< what the receiver says beyond it
  core::MonoTime now_;
  core::MonoTime next_second_;
};

}  // namespace kawara::onboard
