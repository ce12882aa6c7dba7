#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/fixed_text.hpp"
#include "core/time.hpp"

namespace kawara::drivers {

struct ZXtremeConfig {
  char data_port = 'A';       ///< receiver's port our cable is in; the receiver's own answer wins
  char rtcm_port = 'B';       ///< port the corrections come in by; may be the same
  int rtcm_baud_bps = 0;      ///< speed of that port (one of the maker's ten); 0: leave it
  double period_s = 0.1;      ///< of epochs and sentences; below 1 s needs the 10 Hz option
  double pps_period_s = 1.0;  ///< 0: off
  double pps_offset_ms = 0.0;
  char pps_edge = 'R';    ///< R rising, F falling
  char event_edge = 'R';  ///< edge of the shutter pulse that is time-tagged
  int dynamics = 3;       ///< CPD,DYN: 2 walking, 3 car
  bool save = false;      ///< SAV: keep the settings over power-off
  core::Duration reply_timeout = core::Seconds(1);
  int tries = 3;
};

/// What a command is answered with.
enum class ZXtremeReply : std::uint8_t { kAck, kIdentity, kPort, kPps, kEventEdge };

/// One command of the set-up.
struct ZXtremeStep {
  /// Text between '$' and '*'. %d data port, %r corrections port, %b its speed code, %t period, %y
  /// dynamics, %p PPS, %e event edge.
  const char* command;
  ZXtremeReply reply;
  const char* event;  ///< name of the event if it fails
  const char* hint;   ///< what it means then
};

/// All steps in the order they must be taken in: corrections port (RTC,REM) BEFORE rover mode
/// (CPD,MOD,ROV), which the other way round disables CPD; outputs off before the wanted ones are
/// switched on. Source: Z-Family Technical Reference Manual p.35 (PPS, PTT), 60 (rover set-up),
/// 120-128 (commands).
std::span<const ZXtremeStep> ZXtremeSteps();

using ZXtremeCommand = core::FixedText<96>;
/// "$...*cc\r\n", or empty if the configuration leaves this step out. `data_port` as the receiver
/// named it.
ZXtremeCommand MakeCommand(const ZXtremeStep& step, const ZXtremeConfig& config, char data_port);

}  // namespace kawara::drivers
