#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/events.hpp"
#include "core/time.hpp"
#include "drivers/ahrs400.hpp"

namespace kawara::drivers {

struct Ahrs400DialogueConfig {
  Ahrs400Mode mode = Ahrs400Mode::kAngle;
  int model_suffix = 100;  ///< of the configured scaling; checked against the unit's version text
  bool poll = false;       ///< ask for each packet ('G') instead of letting it stream
  core::Duration poll_period = core::Milliseconds(20);
  /// Tried in turn; the first is the port's rate at start. The unit leaves the factory with 38400.
  std::array<int, 6> baud_rates{38400, 9600, 19200, 57600, 115200, 0};  ///< 0 ends the list
  core::Duration quiet = core::Milliseconds(60);  ///< no byte for so long: the stream has stopped
  core::Duration stop_timeout = core::Milliseconds(400);  ///< for one attempt to stop it
  core::Duration reply_timeout = core::Milliseconds(300);
  core::Duration stall = core::Milliseconds(500);  ///< no packet for so long: start over
  int attempts = 3;
};

/// What the owner must do, in order.
struct Ahrs400Action {
  enum class Kind : std::uint8_t { kWrite, kSetBaud, kEvent } kind = Kind::kWrite;
  std::uint8_t byte = 0;                            ///< kWrite: every command is one byte
  int baud_bps = 0;                                 ///< kSetBaud
  core::Severity severity = core::Severity::kInfo;  ///< kEvent
  const char* name = "";                            ///< kEvent: static, "ahrs.running"
  core::EventText text;                             ///< kEvent: one line
};

/// Brings an AHRS400 from whatever state the last run left it in to sending the packets asked for,
/// and does so again when it stalls. A pure state machine: bytes and times in, actions out; no I/O,
/// no clock of its own, no allocation. One thread.
///
///     stop ('P', then 'G', until quiet) -> ping 'R' = 'H' -> version 'v' -> serial number 'S'
///       -> mode 'a'|'c'|'r' = 'A'|'C'|'R' -> continuous 'C' (or 'G' at the poll period) -> running
///
/// A reply counts only when the line was quiet before the command and is again after it: a data
/// byte that looks like 'H' cannot pass. Version and serial number are welcome, not needed. Bytes
/// that fit no packet and no reply, or no answer at all, lead to the next baud rate, and the event
/// says which were tried. Commands and replies: see ahrs400_packet.hpp for the sources. The unit's
/// own auto-baud ('b') is not used: xbow4x reports that it answers but stays at its rate.
class Ahrs400Dialogue {
 public:
  explicit Ahrs400Dialogue(const Ahrs400DialogueConfig& config);

  /// The port is open (at the rate last asked for): begin.
  void Start(core::MonoTime now);
  /// The port is gone: silence until Start.
  void Stop();
  /// Every byte received, also those the decoder gets. Call before OnPacket of the same bytes.
  void OnBytes(core::MonoTime now, std::span<const std::uint8_t> bytes);
  /// The decoder found a packet. `sample` (if not voltages) also serves the check of the
  /// acceleration sign.
  void OnPacket(core::MonoTime now, Ahrs400Mode mode, const core::AhrsSample* sample);
  /// The decoder found the same packet once more: the rate is right, but nothing is measured.
  void OnFrozen() { ++packets_at_baud_; }
  /// Time-outs; call it every 5-20 ms (poll mode: at least at the poll period).
  void Tick(core::MonoTime now);

  bool TryPopAction(Ahrs400Action& out);

  bool running() const { return state_ == State::kRunning; }
  int baud_bps() const { return config_.baud_rates[baud_index_]; }
  /// As the unit said it, trailing blanks cut; "" before.
  std::string_view version() const { return version_.view(); }
  std::optional<std::uint32_t> serial_number() const { return serial_; }
  std::uint64_t restarts() const { return restarts_; }

 private:
  enum class State : std::uint8_t {
    kIdle,
    kStop,
    kPing,
    kVersion,
    kSerial,
    kMode,
    kBegin,
    kRunning
  };

  void Enter(core::MonoTime now, State state);
  void Command(core::MonoTime now);
  void OnReply(core::MonoTime now);
  void OnTimeout(core::MonoTime now);
  void TickStop(core::MonoTime now);
  void TickRunning(core::MonoTime now);
  void NextBaud(core::MonoTime now);
  void TakeVersion(std::span<const std::uint8_t> frame);
  void CheckSign(const core::AhrsSample& sample);
  void Write(std::uint8_t byte);
  void Say(core::Severity severity, const char* name, const core::EventText& text);
  void PushAction(const Ahrs400Action& action);

  Ahrs400DialogueConfig config_;
  State state_ = State::kIdle;
  core::MonoTime entered_;  ///< this state, or its last attempt
  core::MonoTime last_byte_;
  core::MonoTime last_packet_;
  core::MonoTime next_poll_;
  int attempt_ = 0;
  int stop_rounds_ = 0;
  std::size_t baud_index_ = 0;
  std::size_t next_other_ = 0;  ///< the rate last tried beside the usual one
  std::array<std::uint8_t, 96> reply_{};
  std::size_t reply_size_ = 0;
  bool reply_too_long_ = false;
  std::uint64_t bytes_at_baud_ = 0;  ///< received since the rate was set
  std::uint64_t packets_at_baud_ = 0;
  core::FixedText<32> version_;
  std::optional<std::uint32_t> serial_;
  std::uint64_t restarts_ = 0;
  bool announced_ = false;
  int level_samples_ = 0;
  int level_upside_down_ = 0;
  bool sign_checked_ = false;
  std::array<Ahrs400Action, 16> actions_{};
  std::size_t actions_head_ = 0;
  std::size_t actions_count_ = 0;
};

}  // namespace kawara::drivers
