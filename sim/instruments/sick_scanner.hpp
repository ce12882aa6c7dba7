#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/dice.hpp"
#include "sim/instruments/serial_line.hpp"
#include "sim/sim_clock.hpp"

namespace kawara::sim {

constexpr std::size_t kPlsPoints = 361;
constexpr double kPlsMaxRange_m = 50.0;

/// Fills in what a scanner sees: 361 ranges [m], half a degree apart, counter-clockwise seen from
/// above, from its right over ahead (180) to its left; infinity: nothing within reach. `ahead` is
/// when the beam pointed ahead; beam i is kPlsBeamStep * (i - 180) from it.
using RangeCaster = std::function<void(core::GpsTime ahead, std::span<float> ranges_m)>;
/// The mirror turns once in 40 ms, so half a degree takes 40 ms / 720.
constexpr core::Duration kPlsBeamStep = core::Nanoseconds(55'556);

struct SickScannerOptions {
  std::uint8_t address = 0;
  int baud_bps = 9600;     ///< after power-up
  int bits_per_byte = 11;  ///< 8E1, as the PLS sends; a pseudo-terminal carries no parity
  bool fast_line = false;  ///< wired by RS-422: takes 500000 baud
  std::string password = "SICK_PLS";
  double boot_s = 0.0;            ///< from power-up to its first telegram (a real one: 30)
  double mode_change_s = 0.15;    ///< a change of mode takes this long to be answered
  double output_delay_s = 0.002;  ///< last beam to first byte
  double mirror_skew_ppm = 80.0;  ///< its motor against GPS time
  double range_noise_m = 0.015;   ///< standard deviation; the telegram rounds to 1 cm
  double blind_m = 0.07;          ///< nearer things are seen at this distance
  std::uint64_t seed = 11;
};

/// A SICK PLS-101 laser scanner: 180 degrees by half a degree in centimetres, 25 turns a second of
/// which the line lets through what it can (4.8 at 38400 baud). Obeys telegrams (drivers/
/// sick_telegram.hpp): modes 0x24 stream, 0x25 on request, 0x27 part of a scan, baud 0x40 0x41 0x42
/// (0x48 on a fast line), 0x00 installation with its password; 0x30 one scan, 0x31 status, 0x3A
/// type, 0x10 reset. Answers ACK, then the reply; NAK to a bad CRC; 0x92 to what it does not know.
/// A baud change is answered at the old rate. Its status reply tells version and mode only: no
/// public source tells the rest. Sources: as in drivers/sick_telegram.hpp. One thread.
class SickScanner final : public SerialInstrument {
 public:
  /// `clock` must outlive it. Scans begin at `begin` and end at `end`.
  SickScanner(RangeCaster caster, const SimClock& clock, core::GpsTime begin, core::GpsTime end,
              const SickScannerOptions& options);

  UartTransmitter& transmitter() override { return transmitter_; }
  void Receive(core::MonoTime now, std::span<const std::uint8_t> bytes) override;
  void Advance(core::MonoTime now) override;
  core::MonoTime NextEvent() const override;

  /// Power off: silence, and all settings forgotten; on again: as after its reset.
  void SetPower(core::MonoTime now, bool on);

  struct Counters {
    std::uint64_t turns = 0;  ///< of the mirror, whether sent or not
    std::uint64_t scans = 0;  ///< sent
    std::uint64_t telegrams_in = 0;
    std::uint64_t refused = 0;  ///< bad CRC, unknown, wrong password, impossible rate
  };
  const Counters& counters() const { return counters_; }

 private:
  enum class Mode : std::uint8_t {
    kRequest = 0x25,
    kStream = 0x24,
    kStreamPart = 0x27,
    kInstall = 0
  };
  struct Reply {
    core::MonoTime at;
    std::vector<std::uint8_t> payload;
    int new_baud_bps = 0;  ///< once it has been sent; 0: stays
    bool reboot = false;
  };
  void Boot(core::MonoTime now);
  void TakeByte(core::MonoTime now, std::uint8_t byte);
  void Obey(core::MonoTime now, std::span<const std::uint8_t> payload);
  void ObeyMode(core::MonoTime now, std::span<const std::uint8_t> payload);
  bool ObeyPart(std::span<const std::uint8_t> payload);
  void Refuse(core::MonoTime now);
  void SendByte(core::MonoTime now, std::uint8_t byte);
  void SendTelegram(core::MonoTime at, std::vector<std::uint8_t> payload);
  void SendReply();
  void SendScan(core::MonoTime at, core::GpsTime ahead);
  bool Streaming() const { return mode_ == Mode::kStream || mode_ == Mode::kStreamPart; }
  core::GpsTime AheadOfTurn(std::int64_t turn) const;
  core::MonoTime OutputOfTurn(std::int64_t turn) const;

  RangeCaster caster_;
  const SimClock& clock_;
  core::GpsTime begin_, end_;
  SickScannerOptions options_;
  UartTransmitter transmitter_;
  Dice dice_;
  Mode mode_ = Mode::kRequest;
  bool powered_ = true;
  core::MonoTime wakes_at_{};                  ///< set while it boots
  std::size_t first_ = 1, last_ = kPlsPoints;  ///< of a part, counted from 1
  bool one_scan_wanted_ = false;
  std::int64_t next_turn_ = 0;
  std::optional<Reply> reply_;
  std::vector<std::uint8_t> input_;
  core::MonoTime last_input_{};
  std::vector<float> ranges_m_ = std::vector<float>(kPlsPoints);
  Counters counters_;
};

}  // namespace kawara::sim
