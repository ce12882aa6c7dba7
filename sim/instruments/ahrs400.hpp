#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "sim/instruments/ahrs400_packets.hpp"
#include "sim/instruments/serial_line.hpp"
#include "sim/motion/ahrs_trace.hpp"
#include "sim/sim_clock.hpp"

namespace kawara::sim {

struct Ahrs400Options {
  int baud_bps = 38400;
  bool already_streaming = true;  ///< left in continuous angle mode by the last run; else polled
  double counter_skew_ppm =
      35.0;  ///< the unit's crystal against this machine's: positive counts faster
  double processing_s = 0.002;  ///< sample to first bit on the wire
  double temperature_degc = 31.0;
  Ahrs400Ranges ranges;
  std::uint32_t serial_number = 400100;
};

/// A Crossbow AHRS400 replaying a trace: obeys R r c a P C G v S; answers b, but keeps its
/// rate, as observed on a real unit. Packets carry the recorded samples at their
/// recorded instants and a 16-bit down-counter of 0.79 us that runs on the unit's own clock. A
/// sample that finds the line still busy is left out (counted), as the real unit serves its newest
/// one. One thread.
class Ahrs400 final : public SerialInstrument {
 public:
  /// `trace` and `clock` must outlive it; samples outside [begin, end] are not sent.
  Ahrs400(const std::vector<AhrsState>& trace, const SimClock& clock, core::GpsTime begin,
          core::GpsTime end, const Ahrs400Options& options);

  UartTransmitter& transmitter() override { return transmitter_; }
  void Receive(core::MonoTime now, std::span<const std::uint8_t> bytes) override;
  void Advance(core::MonoTime now) override;
  core::MonoTime NextEvent() const override;

  /// Its counter jumps ahead by 20000 ticks (16 ms) while on.
  void SetClockStep(bool on) { clock_step_ = on; }

  struct Counters {
    std::uint64_t samples = 0;  ///< passed
    std::uint64_t packets = 0;  ///< sent
    std::uint64_t skipped = 0;  ///< line busy
    std::uint64_t commands = 0;
    std::uint64_t unknown_bytes = 0;
  };
  const Counters& counters() const { return counters_; }
  std::uint64_t saturated() const { return encoder_.saturated(); }

 private:
  core::MonoTime SampledAt(std::size_t i) const { return clock_.MonoAt(trace_[i].time); }
  std::uint16_t CounterAt(core::MonoTime t) const;
  void Obey(core::MonoTime now, std::uint8_t command);
  void SendPacket(core::MonoTime at, std::size_t index);
  void Reply(core::MonoTime now, char byte);

  const std::vector<AhrsState>& trace_;
  const SimClock& clock_;
  core::GpsTime end_;
  Ahrs400Options options_;
  Ahrs400Encoder encoder_;
  UartTransmitter transmitter_;
  Ahrs400Output output_ = Ahrs400Output::kAngle;
  bool continuous_;
  std::size_t next_;
  std::optional<std::size_t> newest_;  ///< latest sample taken
  bool clock_step_ = false;
  bool polled_ = false;  ///< G waits for the first sample
  Counters counters_;
};

}  // namespace kawara::sim
