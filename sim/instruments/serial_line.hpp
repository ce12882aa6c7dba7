#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/expected.hpp"
#include "core/time.hpp"
#include "sim/dice.hpp"
#include "sim/instruments/uart.hpp"
#include "sim/ports/host_port.hpp"
#include "sim/ports/pty.hpp"

namespace kawara::sim {

/// An instrument as its serial cable sees it: bytes come in, time passes, bytes go out. No I/O, no
/// clock of its own, so that every instrument can be tried out in a unit test. One thread.
class SerialInstrument {
 public:
  virtual ~SerialInstrument() = default;
  virtual UartTransmitter& transmitter() = 0;
  /// Bytes from the host, complete at `now`.
  virtual void Receive(core::MonoTime now, std::span<const std::uint8_t> bytes) = 0;
  /// Does everything that is due by `now`. Called often, with `now` never going back.
  virtual void Advance(core::MonoTime now) = 0;
  /// When Advance() will next have something to do of its own accord; unset: never.
  virtual core::MonoTime NextEvent() const = 0;
};

/// The cable between an instrument and its host's port, with everything that goes wrong on
/// cables: the host's wrong baud (garbage as a real UART would receive, nothing understood the
/// other way), nobody listening (bytes are lost), a reader that is too slow (overrun, counted),
/// silence, garbage, stuck bytes, unplugging. One thread.
class SerialLine {
 public:
  SerialLine(std::unique_ptr<HostPort> port, SerialInstrument& instrument, std::uint64_t seed)
      : port_(std::move(port)), instrument_(instrument), dice_(seed) {}
  SerialLine(Pty pty, SerialInstrument& instrument, std::uint64_t seed)
      : SerialLine(std::make_unique<Pty>(std::move(pty)), instrument, seed) {}

  struct Faults {
    bool unplugged = false;
    bool silent = false;
    bool garbage = false;
    bool stuck = false;  ///< repeats the last good byte
  };
  /// Host's bytes in, instrument advanced to `now`, its due bytes out. Error: replugging failed.
  core::Expected<void> Service(core::MonoTime now, const Faults& faults);
  /// When Service() is worth calling next: exactly at the first byte of a burst, then every
  /// millisecond, as a UART with a small FIFO hands over. Unset: nothing foreseen.
  core::MonoTime NextService() const;

  struct Counters {
    std::uint64_t sent_bytes = 0;     ///< taken by the host's side of the terminal
    std::uint64_t unheard_bytes = 0;  ///< nobody had the port open, or it was unplugged or silenced
    std::uint64_t overrun_bytes = 0;  ///< the host did not read fast enough
    std::uint64_t wrong_baud_bytes = 0;     ///< sent while the host was set to another rate
    std::uint64_t ignored_input_bytes = 0;  ///< from a host at the wrong rate
    std::uint64_t replugs = 0;
  };
  const Counters& counters() const { return counters_; }
  const HostPort& port() const { return *port_; }

 private:
  void TakeInput(core::MonoTime now, const HostPort::HostSide& host);
  void GiveOutput(core::MonoTime now, const HostPort::HostSide& host, const Faults& faults);

  std::unique_ptr<HostPort> port_;
  SerialInstrument& instrument_;
  Dice dice_;
  core::MonoTime last_output_{};
  std::uint8_t last_good_byte_ = 0;
  Counters counters_;
};

}  // namespace kawara::sim
