#pragma once
#include <cstdint>
#include <span>

#include "core/events.hpp"
#include "core/measurements.hpp"
#include "drivers/gnss_epoch.hpp"
#include "drivers/gnss_stream.hpp"
#include "drivers/zxtreme_dialogue.hpp"
#include "onboard/baud_finder.hpp"
#include "onboard/config.hpp"
#include "onboard/core_sink.hpp"

namespace kawara::onboard {

/// What the GPS chain found, for the rest of the core.
class GpsListener {
 public:
  virtual ~GpsListener() = default;
  virtual void OnGpsFix(const core::GnssFix& fix) = 0;
  /// An instant the receiver took the time of, a pulse it gave (PTT) or one it was given (TTT).
  virtual void OnTimeTag(const drivers::AshtechTimeTag& tag, core::MonoTime arrival) = 0;
};

/// From the GPS port's bytes to fixes, and back: the set-up dialogue with the receiver.
/// Tells what ails the receiver: silent, garbage only (wrong baud rate), no fix, RTK state lost.
/// Real-time safe; one thread; a pure function of its calls.
class GpsChain : private drivers::GnssStreamSink, private drivers::GnssFixSink {
 public:
  GpsChain(const GpsConfig& config, core::Events& events, CoreSink& out, GpsListener& listener);

  void OnPort(core::MonoTime now, bool opened);
  void OnBytes(core::MonoTime arrival, std::span<const std::uint8_t> bytes);
  void Tick(core::MonoTime now);
  /// A rough UTC, to date the receiver's first times of day. Only the first call counts.
  void SetReference(core::UtcTime utc);

  /// RTCM may be written to the receiver now.
  bool corrections_allowed() const;
  const drivers::GnssStreamDecoder::Stats& stream_stats() const { return decoder_.stats(); }
  const drivers::GnssEpochAssembler::Stats& epoch_stats() const { return assembler_.stats(); }

 private:
  void OnMessage(const drivers::GnssMessage& message) override;
  void OnFix(const core::GnssFix& fix) override;
  void FindBaud();
  void SpeedUp();
  void CheckHealth();
  void PumpDialogue();

  GpsConfig config_;
  core::Events& events_;
  CoreSink& out_;
  GpsListener& listener_;
  drivers::GnssStreamDecoder decoder_;
  drivers::GnssEpochAssembler assembler_;
  drivers::ZXtremeDialogue dialogue_;
  BaudFinder baud_;
  bool has_reference_ = false;
  bool port_open_ = false;
  core::MonoTime now_;  ///< of the call being handled
  core::MonoTime opened_at_;
  core::MonoTime speed_up_at_;  ///< set: the receiver was told its new rate, ours follows then
  core::MonoTime last_message_;
  core::MonoTime last_position_;
  core::RtkState last_rtk_ = core::RtkState::kNone;
};

}  // namespace kawara::onboard
