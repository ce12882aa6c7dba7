#pragma once
#include <cstddef>
#include <cstdint>

#include "core/events.hpp"
#include "core/time.hpp"
#include "drivers/gnss_message.hpp"
#include "drivers/zxtreme_steps.hpp"

namespace kawara::drivers {

/// Sets up a Z-Xtreme (Z-Family) receiver as RTK rover and listens to what it answers. A state
/// machine without I/O: replies and time go in, command bytes and events come out.
///
/// Each command of zxtreme_steps.hpp waits for ACK or its own reply and is repeated after the
/// time-out; each one that fails gives one event that says what was sent, what came back and what
/// that means. What the receiver answers about itself (identity, port, PPS, event edge) is read
/// back and compared. A receiver that answers nothing at all is taken for a plain NMEA one and left
/// as it is; one that falls silent halfway is given up after three commands.
/// An ACK does not say which command it is for: after a repeated one the dialogue waits until late
/// answers have passed.
/// Corrections must be held back until corrections_allowed(): receivers are known to hang when they
/// come in while being configured.
///
/// Never throws, never allocates. One thread.
class ZXtremeDialogue {
 public:
  enum class State : std::uint8_t {
    kIdle,        ///< before Start
    kAsking,      ///< the dialogue is on
    kConfigured,  ///< all commands accepted
    kPartly,      ///< done, but something was refused or not answered; events said what
    kGeneric,     ///< nobody answered: not an Ashtech receiver, or our line to it is cut
  };

  explicit ZXtremeDialogue(const ZXtremeConfig& config) : config_(config) {}

  /// (Re)starts the dialogue: at start-up and after every reconnect.
  void Start(core::MonoTime now);
  /// Every message of the stream, also those that are no replies.
  void OnMessage(core::MonoTime now, const GnssMessage& message, core::Events& events);
  /// The next bytes to write to the receiver, or empty. Call it after OnMessage and at 10 Hz or
  /// more.
  ZXtremeCommand Poll(core::MonoTime now, core::Events& events);

  State state() const { return state_; }
  bool corrections_allowed() const { return state_ >= State::kConfigured; }
  /// Port letter of our line as the receiver named it; else as configured.
  char data_port() const { return data_port_; }
  /// "UZ,30,ZC00,..." as the receiver said it; empty before.
  std::string_view identity() const { return identity_.view(); }
  /// Steps that were refused, not answered or not as asked.
  int failed_steps() const { return failed_; }

 private:
  const ZXtremeStep& step() const { return ZXtremeSteps()[step_]; }
  void OnAck(core::MonoTime now, bool accepted, core::Events& events);
  void OnIdentity(core::MonoTime now, const AshtechIdentity& identity, core::Events& events);
  void OnPort(core::MonoTime now, const AshtechPort& port, core::Events& events);
  void OnPps(core::MonoTime now, const AshtechPps& pps, core::Events& events);
  void OnEventEdge(core::MonoTime now, const AshtechEventEdge& edge, core::Events& events);
  void OnTimeout(core::MonoTime now, core::Events& events);
  void FailStep(core::MonoTime now, std::string_view what, core::Events& events);
  void NextStep(core::MonoTime now);
  void Finish(core::MonoTime now, core::Events& events);

  ZXtremeConfig config_;
  State state_ = State::kIdle;
  std::size_t step_ = 0;
  int try_ = 0;           ///< of this step, from 1 once sent
  bool waiting_ = false;  ///< a command is out
  bool alive_ = false;    ///< it has answered something
  int silent_steps_ = 0;  ///< in a row
  int failed_ = 0;
  core::MonoTime deadline_;    ///< of the answer
  core::MonoTime send_after_;  ///< late answers pass before this
  char data_port_ = 'A';
  core::FixedText<80> identity_;
  core::FixedText<80> told_identity_;  ///< in the last event; kept over Restart
  core::FixedText<80> said_;           ///< what it said in words (XMG) while a command was out
};

}  // namespace kawara::drivers
