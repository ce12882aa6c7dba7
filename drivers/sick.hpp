#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/time.hpp"
#include "drivers/serial_port.hpp"
#include "drivers/sick_telegram.hpp"
#include "drivers/stamped_buffer.hpp"

namespace kawara::drivers {

/// One scanner as a configuration item. The defaults are a PLS-101; drivers disagree about parity
/// and password there (Player and SickPLS200: even, SICK_PLS; Weis: odd, LASERFUN), so both are
/// settings.
struct SickConfig {
  std::uint8_t address = 0;
  int baud_bps = 38400;
  SerialFormat format = SerialFormat::k8E1;  ///< PLS: even, else odd. LMS2xx: none
  std::string password = "SICK_PLS";
  int range_bits = 13;           ///< PLS and LMS in 8 m mode; LMS 16 m: 14, 32 m: 15, 80 m: 16
  bool decode_requests = false;  ///< also telegrams TO the scanner (recordings of both directions)
  /// One turn of the mirror: 40 ms on a PLS (25 Hz), 13.3 ms on an LMS2xx (75 Hz).
  core::Duration mirror_period = core::Milliseconds(40);
  /// From the last beam of the half turn to the first byte on the line.
  core::Duration output_delay = core::Nanoseconds(0);

  static SickConfig Pls101();
  static SickConfig Lms2xx();
  /// Bits a character times baud: 11 bits with parity.
  core::Duration ByteTime() const;
};

/// Any telegram with a good CRC. Views end with the call.
struct SickMessage {
  core::MonoTime arrival;    ///< first byte (STX)
  std::uint8_t address = 0;  ///< as sent: 0x80 added from the scanner
  std::uint8_t command = 0;
  std::span<const std::uint8_t> data;      ///< after the command, status byte included
  std::span<const std::uint8_t> telegram;  ///< whole
  bool FromScanner() const { return (address & 0x80U) != 0; }
};

constexpr std::size_t kSickMaxPoints = 1023;

/// One sweep of distances, counter-clockwise seen from above, from the scanner's right (0) over
/// ahead (pi/2) to its left (pi): x = r cos, y = r sin.
struct SickScan {
  core::MonoTime arrival;    ///< first byte of the telegram
  core::MonoTime mid_sweep;  ///< when the beam pointed ahead: arrival - output delay - quarter turn
  core::Duration mirror_period{};
  double metres_per_count = 0.01;
  double first_angle_rad = 0.0;
  double step_rad = 0.0;  ///< 0: unknown number of points, angles cannot be told
  std::uint8_t command = 0xB0;
  std::uint8_t partial_index = 0;  ///< quarter degrees a coarse sweep is shifted (LMS interlaced)
  std::uint8_t status = 0;         ///< last byte of the telegram; bit 7: front window dirty
  int range_bits = 13;
  std::size_t size = 0;
  std::array<std::uint16_t, kSickMaxPoints> words{};

  std::uint16_t RangeMask() const { return static_cast<std::uint16_t>((1U << range_bits) - 1U); }
  double RangeM(std::size_t i) const { return (words[i] & RangeMask()) * metres_per_count; }
  /// Fields A, B, C or dazzle, from bit 0.
  std::uint8_t Flags(std::size_t i) const {
    return static_cast<std::uint8_t>(words[i] >> range_bits);
  }
  double AngleRad(std::size_t i) const {
    return first_angle_rad + static_cast<double>(i) * step_rad;
  }
  core::MonoTime BeamTime(std::size_t i) const;
};

class SickSink {
 public:
  virtual ~SickSink() = default;
  virtual void OnScan(const SickScan& /*scan*/) {
  }  ///< commands 0xB0 and 0xB7; OnMessage came before
  virtual void OnMessage(const SickMessage& /*message*/) {}
  virtual void OnAcknowledge(core::MonoTime /*arrival*/, bool /*accepted*/) {}  ///< ACK or NAK byte
};

struct SickStats {
  std::uint64_t telegrams = 0;
  std::uint64_t scans = 0;
  std::uint64_t bad_checksum = 0;  ///< of telegrams that were due, and of scans anywhere
  std::uint64_t bad_scans = 0;     ///< good CRC, but count and length disagree
  std::uint64_t acks = 0;
  std::uint64_t naks = 0;
  std::uint64_t telegram_bytes = 0;
  std::uint64_t skipped_bytes = 0;
};

/// Bytes of the line to telegrams and scans. Takes any byte split; a telegram comes out at its last
/// byte, dated by its first. Framing: STX, an address that is ours, a possible length, for scans a
/// count that fits the length, and the CRC; on any failure the search goes on one byte later. ACK
/// and NAK are single bytes and count only directly after a telegram, another of them, or at the
/// start. Never throws, never allocates. One thread. Pure function of its inputs.
class SickDecoder {
 public:
  explicit SickDecoder(const SickConfig& config = {});

  /// `arrival`: first byte of `bytes`.
  void Feed(core::MonoTime arrival, std::span<const std::uint8_t> bytes, SickSink& sink);
  /// The data has ended: what cannot be completed any more is skipped, whole telegrams inside it
  /// come out.
  void Finish(SickSink& sink);
  void Reset();
  const SickStats& stats() const { return stats_; }
  /// Inside a call of the sink: place in the stream of the first byte of what it is given.
  std::uint64_t position() const { return buffer_.position(); }

 private:
  enum class Shape { kNo, kNeedMore, kWhole };

  void Parse(SickSink& sink, bool ended);
  Shape JudgeShape(std::span<const std::uint8_t> data, std::size_t& total) const;
  void Take(std::size_t total, SickSink& sink);
  void TakeScan(const SickMessage& message, SickSink& sink);
  void SetAngles(std::span<const std::uint8_t> payload);
  void Skip(std::size_t n);

  SickConfig config_;
  StampedBuffer<8192> buffer_;
  bool in_step_ = true;
  SickScan scan_;
  SickStats stats_;
};

}  // namespace kawara::drivers
