#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "core/expected.hpp"

namespace kawara::sim {

/// The far end of an instrument's serial cable: where the robot's computer has its port. A real
/// pseudo-terminal (Pty), or one that only exists inside a program (VirtualPort). One thread.
class HostPort {
 public:
  virtual ~HostPort() = default;

  virtual bool plugged() const = 0;
  /// Cable out: the host notices.
  virtual void Unplug() = 0;
  /// Cable in again.
  virtual core::Expected<void> Replug() = 0;

  /// What the host has made of the port.
  struct HostSide {
    bool open = false;    ///< somebody has the device open
    int baud_bps = 0;     ///< 0: a rate termios has no number for
    bool parity = false;  ///< kernels so far never show it on a pseudo-terminal
  };
  virtual HostSide host() const = 0;

  /// Never blocks. Returns how many bytes went in; the rest met a full buffer (nobody reads).
  virtual std::size_t Write(std::span<const std::uint8_t> bytes) = 0;
  /// Never blocks. Returns how many bytes the host had sent.
  virtual std::size_t Read(std::span<std::uint8_t> bytes) = 0;
  /// "/dev/pts/7"; empty while unplugged.
  virtual const std::string& device() const = 0;
};

}  // namespace kawara::sim
