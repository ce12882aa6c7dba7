#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "core/expected.hpp"
#include "sim/ports/host_port.hpp"

namespace kawara::sim {

/// A serial port for somebody else to open: a pseudo-terminal behind a symbolic link of fixed name,
/// as udev's by-id links are. Bytes written here come out there. What it cannot imitate (Linux 6):
/// parity (the kernel drops PARENB silently), modem lines, pace (see UartTransmitter). One thread.
class Pty final : public HostPort {
 public:
  /// Creates the terminal, raw at 9600 baud as a fresh Linux serial port, and the link (an old link
  /// is replaced; anything else of that name is not: kInvalidArgument).
  static core::Expected<Pty> Create(const std::filesystem::path& link);
  Pty(Pty&& other) noexcept;
  Pty& operator=(Pty&&) = delete;
  ~Pty() override;  ///< unplugs

  bool plugged() const override { return master_fd_ >= 0; }
  const std::string& device() const override { return device_; }
  const std::filesystem::path& link() const { return link_; }

  /// Cable out: the host sees end of file and I/O errors, the node and the link are gone.
  void Unplug() override;
  /// Cable in: same link, and a device of another number than before, whatever the host still holds
  /// open.
  core::Expected<void> Replug() override;

  HostSide host() const override;
  std::size_t Write(std::span<const std::uint8_t> bytes) override;
  std::size_t Read(std::span<std::uint8_t> bytes) override;

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
