#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string>

#include "core/time.hpp"
#include "sim/instruments/uart.hpp"
#include "sim/ports/host_port.hpp"

namespace kawara::sim {

/// A serial port that only exists inside this program, for runs in virtual time: the instrument's
/// cable on the one side, a host that opens, reads and writes on the other. What the host writes
/// leaves at the pace of its baud rate. One thread.
class VirtualPort final : public HostPort {
 public:
  explicit VirtualPort(std::string name) : name_(std::move(name)), device_(name_) {}

  // The instrument's side.
  bool plugged() const override { return !device_.empty(); }
  void Unplug() override;
  core::Expected<void> Replug() override;
  HostSide host() const override { return {.open = open_, .baud_bps = baud_bps_, .parity = false}; }
  std::size_t Write(std::span<const std::uint8_t> bytes) override;
  std::size_t Read(std::span<std::uint8_t> bytes) override;
  const std::string& device() const override { return device_; }

  // The host's side.
  /// What is read from here on is what has left the host's UART by now.
  void SetTime(core::MonoTime now) { now_ = now; }
  /// Throws away what came before. False: there is no cable.
  bool Open(int baud_bps);
  bool open() const { return open_; }
  void SetBaud(int baud_bps);
  int baud_bps() const { return baud_bps_; }
  std::size_t waiting() const { return to_host_.size(); }
  std::size_t HostRead(std::span<std::uint8_t> bytes);
  void HostWrite(core::MonoTime now, std::span<const std::uint8_t> bytes);
  /// When the next byte written by the host has left; unset: none under way.
  core::MonoTime NextByteOut() const { return transmitter_.NextSent(); }

 private:
  std::string name_;
  std::string device_;  ///< empty while unplugged
  bool open_ = false;
  int baud_bps_ = 9600;
  core::MonoTime now_;
  std::deque<std::uint8_t> to_host_;
  UartTransmitter transmitter_{9600, 8192};
};

}  // namespace kawara::sim
