#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "core/expected.hpp"

namespace kawara::sim {

/// A serial port for somebody else to open: a pseudo-terminal behind a symbolic link of fixed name,
/// as udev's by-id links are. Bytes written here come out there. What it cannot imitate (Linux 6):
/// parity (the kernel drops PARENB silently), modem lines, pace (see UartTransmitter). One thread.
class Pty {
 public:
  /// Creates the terminal, raw at 9600 baud as a fresh Linux serial port, and the link (an old link
  /// is replaced; anything else of that name is not: kInvalidArgument).
  static core::Expected<Pty> Create(const std::filesystem::path& link);
  Pty(Pty&& other) noexcept;
  Pty& operator=(Pty&&) = delete;
  ~Pty();  ///< unplugs

  bool plugged() const { return master_fd_ >= 0; }
  /// "/dev/pts/7"; empty while unplugged.
  const std::string& device() const { return device_; }
  const std::filesystem::path& link() const { return link_; }

  /// Cable out: the host sees end of file and I/O errors, the node and the link are gone.
  void Unplug();
  /// Cable in: same link, and a device of another number than before, whatever the host still holds
  /// open.
  core::Expected<void> Replug();

  /// What the host has made of the port.
  struct HostSide {
    bool open = false;    ///< somebody has the device open
    int baud_bps = 0;     ///< 0: a rate termios has no number for
    bool parity = false;  ///< see above: kernels so far never show it
  };
  HostSide host() const;

  /// Never blocks. Returns how many bytes went in; the rest met a full buffer (nobody reads).
  std::size_t Write(std::span<const std::uint8_t> bytes);
  /// Never blocks. Returns how many bytes the host had sent.
  std::size_t Read(std::span<std::uint8_t> bytes);

 private:
  explicit Pty(std::filesystem::path link) : link_(std::move(link)) {}
  core::Expected<void> Plug();

  std::filesystem::path link_;
  std::string device_;
  int master_fd_ = -1;
  int reserved_fd_ =
      -1;  ///< the unplugged device's node, held so that its number is not given out again
};

}  // namespace kawara::sim
