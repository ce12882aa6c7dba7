#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/measurements.hpp"
#include "drivers/ahrs400_packet.hpp"
#include "drivers/counter_clock.hpp"
#include "drivers/stamped_buffer.hpp"

namespace kawara::drivers {

struct Ahrs400Config {
  Ahrs400Scaling scaling;
  /// What 24-byte packets mean (scaled and voltage look alike) and which length is tried first.
  Ahrs400Mode mode = Ahrs400Mode::kAngle;
  bool any_length =
      true;  ///< also lock onto the other packet length, so that a wrong mode is noticed
  core::Duration byte_time = core::Nanoseconds(260'417);  ///< 10 bits at 38400 baud
  CounterClockConfig clock;
};

/// Receives what an Ahrs400Decoder finds. Override what you want.
class Ahrs400Sink {
 public:
  virtual ~Ahrs400Sink() = default;
  virtual void OnSample(const core::AhrsSample& /*sample*/, Ahrs400Mode /*mode*/) {}
  virtual void OnVoltages(const Ahrs400Voltages& /*voltages*/) {}
  /// The unit repeats itself: same payload, same counter as the packet before. Not a measurement.
  virtual void OnFrozen(core::MonoTime /*arrival*/, Ahrs400Mode /*mode*/) {}
  /// 24 characters; the view ends with the call.
  virtual void OnVersion(std::string_view /*text*/) {}
  virtual void OnSerialNumber(std::uint32_t /*number*/) {}
};

struct Ahrs400Stats {
  std::array<std::uint64_t, 3> packets{};  ///< by Ahrs400Mode, frozen ones included
  std::uint64_t versions = 0;
  std::uint64_t serial_numbers = 0;
  std::uint64_t bad_checksum = 0;  ///< at a place where a packet was due
  std::uint64_t skipped_bytes = 0;
  std::uint64_t frozen = 0;
  std::uint64_t locks = 0;  ///< times the framing was found anew
  std::uint64_t Good() const {
    return packets[0] + packets[1] + packets[2] + versions + serial_numbers;
  }
};

/// Bytes of an AHRS400 to samples. Takes any byte split; each packet comes out at its last byte,
/// dated by its FIRST byte (arrival) and by its counter on this machine's clock (sampled, see
/// CounterClock).
///
/// Framing: the header byte 0xFF also occurs in payloads and the checksum has 8 bits only, so a
/// packet counts
///   * at once where one is due: right after the last one, or a whole number (<= 8) of packet
///   lengths on;
///   * elsewhere when the one or two packets that follow it check as well: one if temperature and
///   pitch of
///     both are possible, else two. Nothing is lost by that, the held-back packet comes out with
///     its stamp.
/// After a wrong header or checksum the search goes on ONE byte later. Version replies are known by
/// their text, a serial number only directly after a version reply (its 6 bytes prove nothing
/// elsewhere).
///
/// Never throws, never allocates. One thread. Pure function of its inputs.
class Ahrs400Decoder {
 public:
  explicit Ahrs400Decoder(const Ahrs400Config& config = {});

  /// `arrival`: first byte of `bytes`.
  void Feed(core::MonoTime arrival, std::span<const std::uint8_t> bytes, Ahrs400Sink& sink);
  /// The data has ended (file, port lost): a last packet that nothing can confirm any more comes
  /// out now.
  void Finish(Ahrs400Sink& sink);
  /// Forgets bytes and framing, keeps the counts. After reopening the port.
  void Reset();

  const Ahrs400Stats& stats() const { return stats_; }
  const CounterClock& clock() const { return clock_; }
  bool locked() const { return locked_; }
  /// Inside a call of the sink: place in the stream of the first byte of what it is given.
  std::uint64_t position() const { return buffer_.position(); }

 private:
  enum class Verdict { kNothing, kNeedMore, kPacket, kVersion, kSerial };
  struct Judgement {
    Verdict verdict = Verdict::kNothing;
    Ahrs400Mode mode = Ahrs400Mode::kAngle;
  };
  static constexpr std::size_t kMaxPending = 3 * kAhrs400AnglePacketBytes;
  static constexpr std::uint64_t kGridReach = 8;

  void Parse(Ahrs400Sink& sink, bool ended);
  std::size_t CountHopeless(std::span<const std::uint8_t> data) const;
  Judgement Judge(std::span<const std::uint8_t> data, bool ended);
  Verdict JudgeElsewhere(std::span<const std::uint8_t> data, Ahrs400Mode mode, bool ended) const;
  bool IsDue(std::size_t packet_bytes) const;
  void Skip(std::size_t n);
  void TakePacket(Ahrs400Mode mode, Ahrs400Sink& sink);
  bool IsFrozen(std::span<const std::uint8_t> frame, Ahrs400Mode mode);

  Ahrs400Config config_;
  CounterClock clock_;
  StampedBuffer<4096> buffer_;
  bool locked_ = false;                   ///< a packet is due at the front of the buffer
  std::optional<Ahrs400Mode> grid_mode_;  ///< of the last packet
  std::uint64_t grid_position_ = 0;       ///< stream position right after it
  bool after_version_ = false;
  bool bytes_lost_ = false;  ///< skipped something since the last packet
  std::array<std::uint8_t, kAhrs400AnglePacketBytes> last_frame_{};
  Ahrs400Mode last_mode_ = Ahrs400Mode::kAngle;
  bool has_last_ = false;
  Ahrs400Stats stats_;
};

}  // namespace kawara::drivers
