#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "core/fixed_text.hpp"
#include "core/time.hpp"
#include "drivers/serial_port.hpp"

namespace kawara::drivers {

struct ReconnectConfig {
  SerialConfig serial;
  core::Duration backoff_min = core::Milliseconds(200);
  core::Duration backoff_max = core::Seconds(2);
  core::Duration silence =
      core::Seconds(3);  ///< open but no byte for so long is reported; 0: never
  core::Duration reminder = core::Seconds(30);  ///< between two "still missing"
  bool open_in_background = true;               ///< false: Service opens itself (tests, tools)
};

enum class PortEventKind : std::uint8_t {
  kOpened,
  kLost,          ///< unplugged or hung up; the file descriptor is closed already
  kStillMissing,  ///< first failure to open, then every `reminder`
  kSilent,        ///< open, but nothing comes
  kTalking,       ///< bytes again after kSilent
};
const char* ToString(PortEventKind k);  ///< "opened", "lost", "missing", "silent", "talking"

struct PortEvent {
  core::MonoTime stamp;
  PortEventKind kind = PortEventKind::kOpened;
  core::FixedText<200> text;  ///< one line, names the device
};

struct PortCounters {
  std::uint64_t bytes_in = 0;
  std::uint64_t bytes_out = 0;
  std::uint64_t bytes_not_written = 0;  ///< offered while closed or without room
  std::uint64_t opened = 0;
  std::uint64_t lost = 0;
  std::uint64_t failed_opens = 0;
};

/// A serial port that comes back. Owns the descriptor, looks the path up anew at each try (so a
/// by-id link finds its device under another ttyUSB number) and closes a dead descriptor AT ONCE:
/// while it stays open the kernel would give the returning adapter the next number.
///
/// No call waits: opening (slow on USB adapters) is done by a helper thread of normal priority,
/// picked up by the next Service(). Read/Write/Service do not allocate while the port is healthy.
/// One thread; times are what the caller passes in.
class ReconnectingPort {
 public:
  explicit ReconnectingPort(ReconnectConfig config);
  ReconnectingPort(ReconnectingPort&&) = delete;
  ~ReconnectingPort();

  /// Opens, or asks for it, when due; notices silence. Call it every 10-100 ms and after a Read.
  void Service(core::MonoTime now);

  bool is_open() const { return port_.has_value(); }
  /// For poll(); -1 while closed.
  int fd() const { return port_ ? port_->fd() : -1; }
  /// Counts openings: when it changes, restart decoders and dialogues.
  std::uint64_t generation() const { return counters_.opened; }

  /// Bytes that are here, 0 if none or closed. `now`: when poll returned, or MonoNow().
  std::size_t Read(core::MonoTime now, std::span<std::uint8_t> buffer);
  core::MonoTime first_byte_arrival() const {
    return port_ ? port_->first_byte_arrival() : core::MonoTime{};
  }
  /// Bytes taken (all or the first part); the rest is counted as not written.
  std::size_t Write(core::MonoTime now, std::span<const std::uint8_t> bytes);
  /// Now and for every later opening.
  core::Expected<void> SetBaud(int baud_bps);
  /// Closes and opens again after the shortest back-off (a device that answers nonsense).
  void Reopen(core::MonoTime now, std::string_view why);

  bool TryPopEvent(PortEvent& out);
  const PortCounters& counters() const { return counters_; }
  const ReconnectConfig& config() const { return config_; }
  const SerialPort* port() const { return port_ ? &*port_ : nullptr; }

 private:
  class Opener;

  void TakeResult(core::MonoTime now, core::Expected<SerialPort> result);
  void Lose(core::MonoTime now, std::string_view why);
  void Push(core::MonoTime now, PortEventKind kind, const core::FixedText<200>& text);

  ReconnectConfig config_;
  std::optional<SerialPort> port_;
  std::unique_ptr<Opener> opener_;
  bool opening_ = false;
  core::Duration backoff_;
  core::MonoTime next_try_;
  core::MonoTime missing_since_;
  core::MonoTime reminded_at_;
  core::MonoTime last_byte_;
  bool silent_ = false;
  PortCounters counters_;
  std::array<PortEvent, 16> events_;
  std::size_t events_head_ = 0;
  std::size_t events_count_ = 0;
};

}  // namespace kawara::drivers
