#pragma once
#include <cstdint>
#include <string_view>

#include "core/events.hpp"
#include "core/fixed_text.hpp"
#include "core/time.hpp"
#include "drivers/gnss_message.hpp"

namespace kawara::drivers {

struct ZXtremeConfig {
  char data_port = 'A';       ///< receiver's port our cable is in; the receiver's own answer wins
  char rtcm_port = 'B';       ///< port the corrections come in by; may be the same
  int rtcm_baud_bps = 0;      ///< speed of that port; 0: leave it
  double period_s = 0.1;      ///< of epochs and sentences
  double pps_period_s = 1.0;  ///< 0: off
  double pps_offset_ms = 0.0;
  char pps_edge = 'R';
  char event_edge = 'R';  ///< edge of the shutter pulse that is time-tagged
  int dynamics = 3;       ///< CPD,DYN: 2 walking, 3 car
  bool save = false;      ///< SAV: keep the settings over power-off
  core::Duration reply_timeout = core::Seconds(1);
  int tries = 3;
};

/// Sets up a Z-Xtreme (Z-Family) receiver as RTK rover and listens to what it answers. A state
/// machine without I/O: replies and time go in, command bytes and events come out.
///
/// Order: who are you (RID), which port is this (PRT), everything off, corrections port BEFORE
/// rover mode (the other way round disables CPD), CPD options, periods, the wanted sentences on,
/// PPS and event edge with read-back, and the settings are stored only if asked for. Each command
/// waits for ACK or its own reply, is repeated after the time-out, and each one that fails gives
/// one event that says what was sent and what came back. A receiver that answers nothing at all is
/// taken for a plain NMEA one and left as it is. Corrections must be held back until
/// corrections_allowed(): some receivers hang when they come in between. Source: Z-Family Technical
/// Reference Manual p.35-37, 60-64, 120-128; gpsd (ACK, NAK, RID). Never throws, never allocates.
/// One thread.
class ZXtremeDialogue {
 public:
  enum class State : std::uint8_t {
    kIdle,        ///< before Start
    kAsking,      ///< the dialogue is on
    kConfigured,  ///< all commands accepted
    kPartly,      ///< done, but something was refused or not answered; events said what
    kGeneric,     ///< nobody answered: not an Ashtech receiver, or our line to it is cut
  };
  using Command = core::FixedText<96>;

  explicit ZXtremeDialogue(const ZXtremeConfig& config);

  /// (Re)starts the dialogue: at start-up and after every reconnect.
  void Start(core::MonoTime now);
  void OnMessage(core::MonoTime now, const GnssMessage& message, core::Events& events);
  /// The next bytes to write to the receiver, or empty. Call it after OnMessage and at 10 Hz or
  /// more.
  Command Poll(core::MonoTime now, core::Events& events);

  State state() const { return state_; }
  bool corrections_allowed() const { return state_ >= State::kConfigured; }

 private:
  ZXtremeConfig config_;
  State state_ = State::kIdle;
};

}  // namespace kawara::drivers
