#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "core/time.hpp"

namespace kawara::sim {

/// The sending half of an instrument's serial port: bytes leave one after the other, each takes ten
/// bit times (8N1; eleven with parity), on an absolute schedule that neither drifts nor bunches. A
/// pseudo-terminal has no pace of its own: 480 bytes "at 4800 baud" arrive there within
/// microseconds. One thread.
class UartTransmitter {
 public:
  /// `buffer_bytes`: what the instrument can hold back before it drops whole messages.
  explicit UartTransmitter(int baud_bps, std::size_t buffer_bytes = 4096, int bits_per_byte = 10);

  /// For bytes sent from now on; what is already queued leaves at the old rate.
  void SetBaud(int baud_bps) { baud_bps_ = baud_bps; }
  int baud_bps() const { return baud_bps_; }

  /// Queues a whole message whose first bit may leave at `at`. False: buffer full, message dropped
  /// and counted.
  bool Send(core::MonoTime at, std::span<const std::uint8_t> message);
  /// Instant at which everything queued will have left (at least `at`).
  core::MonoTime FreeAt(core::MonoTime at) const { return std::max(at, line_free_); }

  /// Takes the bytes whose last bit has left by `now`; all at one rate: `baud_bps` says at which.
  struct Chunk {
    int baud_bps = 0;
    std::vector<std::uint8_t> bytes;
  };
  Chunk TakeSent(core::MonoTime now);
  /// When the next byte will have left; unset: nothing queued.
  core::MonoTime NextSent() const {
    return queue_.empty() ? core::MonoTime{} : queue_.front().sent;
  }
  void Clear();  ///< power off

  std::uint64_t dropped_messages() const { return dropped_messages_; }

 private:
  struct Byte {
    core::MonoTime sent;
    int baud_bps;
    std::uint8_t value;
  };
  int baud_bps_;
  std::size_t buffer_bytes_;
  int bits_per_byte_;
  core::MonoTime line_free_{};
  std::deque<Byte> queue_;
  std::uint64_t dropped_messages_ = 0;
};

/// What a UART set to `receive_baud_bps` makes of bytes sent back to back at `send_baud_bps`: it
/// looks for a start edge in the waveform and samples at its own pace, so that it delivers other
/// bytes, more or fewer. 8N1 on both sides; framing errors are delivered as they are, like Linux
/// does without INPCK.
std::vector<std::uint8_t> ReceiveAtWrongBaud(std::span<const std::uint8_t> sent, int send_baud_bps,
                                             int receive_baud_bps);

}  // namespace kawara::sim
