#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/expected.hpp"
#include "core/time.hpp"

namespace kawara::drivers {

enum class SerialFormat : std::uint8_t { k8N1, k8E1, k8O1 };
const char* ToString(SerialFormat f);  ///< "8N1", "8E1", "8O1"

/// How the first byte of a chunk is dated; see SerialPort::Read.
enum class StampRule : std::uint8_t {
  kAuto,      ///< kLineRate on a wire, kReadTime on a pseudo-terminal (which has no line rate)
  kLineRate,  ///< back from the read by the time the bytes took on the wire
  kReadTime,  ///< when the reader woke up or read, nothing subtracted
};

struct SerialConfig {
  std::string device;    ///< a by-id link survives renumbering: /dev/serial/by-id/...
  int baud_bps = 38400;  ///< any rate the hardware can make, 50..4000000
  SerialFormat format = SerialFormat::k8N1;
  bool low_latency = true;  ///< ASYNC_LOW_LATENCY: an FTDI hands bytes over after 1 ms, not 16
  StampRule stamp = StampRule::kAuto;
};

/// What the driver really did, read back after setting. A pseudo-terminal drops parity without a
/// word.
struct SerialGranted {
  int baud_bps = 0;
  SerialFormat format = SerialFormat::k8N1;
  bool low_latency = false;
  bool modem_lines = false;  ///< RTS and DTR can be set
  bool pseudo_terminal = false;
};

/// What the UART and its driver counted since the device appeared. Frame errors at a steady rate
/// mean a wrong baud rate, overruns a reader that came too late.
struct SerialLineErrors {
  std::uint32_t frame = 0, parity = 0, overrun = 0, buffer_overrun = 0, breaks = 0;
};

/// A raw serial line (POSIX termios), ours alone: TIOCEXCL and flock keep a second reader out. No
/// echo, no translation, no flow control; modem lines are ignored and stay as they are at close
/// (HUPCL off). Input from before Open is thrown away.
///
/// Nothing here ever waits: wait with poll(fd()). Read and Write do one system call and do not
/// allocate (the texts of their errors are short enough for std::string's own buffer); Open is slow
/// (USB adapters answer several control requests) and builds long texts, so it belongs to a slower
/// thread. One thread at a time.
class SerialPort {
 public:
  /// Errors, one line each with its cure: kNotFound (lists the ports there are), kPermission (which
  /// group), kUnavailable (held by whom), kInvalidArgument (not a serial port, impossible baud
  /// rate), kIo.
  static core::Expected<SerialPort> Open(const SerialConfig& config);

  SerialPort(SerialPort&& other) noexcept;
  SerialPort& operator=(SerialPort&& other) noexcept;
  ~SerialPort();

  /// Up to `buffer.size()` bytes that are here already; 0: nothing now. kUnavailable: unplugged or
  /// hung up, close it. `woke`: when poll() returned for this read, if known.
  ///
  /// Dating (kLineRate): bytes leave the wire one character time apart, so the first of n was here
  /// at the latest (n-1) character times before the read, and before `woke`; it was NOT here when
  /// an earlier read found the line empty. The stamp is the earlier of the first two, not before
  /// the third: never too early for bytes that really came over a wire, late only by what the
  /// adapter held them back. A stamp that is never early is what an earliest-arrival envelope
  /// needs.
  core::Expected<std::size_t> Read(std::span<std::uint8_t> buffer, core::MonoTime woke = {});
  /// Stamp of the first byte of the last Read that returned any.
  core::MonoTime first_byte_arrival() const { return first_byte_; }

  /// Takes as many bytes as the driver has room for now (0: none). kUnavailable: unplugged.
  core::Expected<std::size_t> Write(std::span<const std::uint8_t> bytes);

  core::Expected<void> SetBaud(int baud_bps);
  /// Raises and drops RTS and DTR in one call each. kUnavailable on a line without them.
  core::Expected<void> SetModemLines(std::optional<bool> rts, std::optional<bool> dtr);
  /// Empty where the driver does not count (pseudo-terminals, CDC-ACM).
  std::optional<SerialLineErrors> LineErrors() const;
  /// Throws away what was received and not read.
  void DiscardInput();

  int fd() const { return fd_; }
  const SerialConfig& config() const { return config_; }
  const SerialGranted& granted() const { return granted_; }
  /// Start bit to stop bit at the granted rate.
  core::Duration character_time() const { return character_time_; }

 private:
  SerialPort(int fd, SerialConfig config);
  core::Expected<void> Configure();
  void Close();

  int fd_ = -1;
  SerialConfig config_;
  SerialGranted granted_;
  core::Duration character_time_{};
  core::MonoTime line_empty_at_;  ///< the kernel's buffer was empty no earlier than this
  core::MonoTime first_byte_;
};

/// The rule of Read on bare numbers (tests, replays of strace logs). `read_done`: just after read()
/// returned.
core::MonoTime DateFirstByte(std::size_t bytes, core::MonoTime line_empty_at, core::MonoTime woke,
                             core::MonoTime read_done, core::Duration character_time);

}  // namespace kawara::drivers
