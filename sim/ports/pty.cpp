#include "sim/ports/pty.hpp"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <system_error>
#include <utility>

namespace kawara::sim {
namespace {

struct BaudCode {
  speed_t code;
  int baud_bps;
};
constexpr std::array<BaudCode, 15> kBaudCodes{{{B300, 300},
                                               {B600, 600},
                                               {B1200, 1200},
                                               {B2400, 2400},
                                               {B4800, 4800},
                                               {B9600, 9600},
                                               {B19200, 19200},
                                               {B38400, 38400},
                                               {B57600, 57600},
                                               {B115200, 115200},
                                               {B230400, 230400},
                                               {B460800, 460800},
                                               {B500000, 500000},
                                               {B921600, 921600},
                                               {B1000000, 1000000}}};

int BaudOf(speed_t code) {
  for (const BaudCode& known : kBaudCodes) {
    if (known.code == code) return known.baud_bps;
  }
  return 0;
}

void CloseFd(int& fd) {
  if (fd >= 0) close(fd);
  fd = -1;
}

}  // namespace

core::Expected<Pty> Pty::Create(const std::filesystem::path& link) {
  std::error_code error;
  const auto status = std::filesystem::symlink_status(link, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_symlink(status)) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      link.string() + ": exists and is no link; choose another --run-dir");
  }
  Pty pty(link);
  const core::Expected<void> plugged = pty.Plug();
  if (!plugged) return tl::unexpected(plugged.error());
  return pty;
}

Pty::Pty(Pty&& other) noexcept
    : link_(std::move(other.link_)),
      device_(std::move(other.device_)),
      master_fd_(std::exchange(other.master_fd_, -1)),
      reserved_fd_(std::exchange(other.reserved_fd_, -1)) {}

Pty::~Pty() {
  if (plugged()) Unplug();
  CloseFd(reserved_fd_);
}

core::Expected<void> Pty::Plug() {
  int slave_fd = -1;
  if (openpty(&master_fd_, &slave_fd, nullptr, nullptr, nullptr) != 0) {
    return tl::unexpected(core::ErrnoError("open a pseudo-terminal", errno));
  }
  std::array<char, 64> name{};
  termios settings{};
  if (ptsname_r(master_fd_, name.data(), name.size()) != 0 || tcgetattr(slave_fd, &settings) != 0) {
    const core::Error error = core::ErrnoError("set up a pseudo-terminal", errno);
    CloseFd(slave_fd);
    CloseFd(master_fd_);
    return tl::unexpected(error);
  }
  cfmakeraw(&settings);
  cfsetspeed(&settings, B9600);
  tcsetattr(slave_fd, TCSANOW, &settings);
  // With its own end closed once, the master reports POLLHUP until a host opens the device.
  CloseFd(slave_fd);
  fcntl(master_fd_, F_SETFL, O_NONBLOCK);
  fcntl(master_fd_, F_SETFD, FD_CLOEXEC);
  device_ = name.data();

  // A link made beside and renamed over: whoever opens it finds the old device or the new, never
  // nothing.
  const std::filesystem::path fresh = link_.string() + ".new";
  std::error_code error;
  std::filesystem::remove(fresh, error);
  std::filesystem::create_symlink(device_, fresh, error);
  if (!error) std::filesystem::rename(fresh, link_, error);
  if (error) {
    CloseFd(master_fd_);
    return core::Fail(core::ErrorCode::kIo, "link " + link_.string() + ": " + error.message());
  }
  return {};
}

void Pty::Unplug() {
  if (!plugged()) return;
  std::error_code ignored;
  std::filesystem::remove(link_, ignored);
  CloseFd(reserved_fd_);
  reserved_fd_ = open(device_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  CloseFd(master_fd_);
  device_.clear();
}

core::Expected<void> Pty::Replug() {
  if (plugged()) return {};
  core::Expected<void> plugged = Plug();
  CloseFd(reserved_fd_);
  return plugged;
}

Pty::HostSide Pty::host() const {
  HostSide side;
  if (!plugged()) return side;
  pollfd poll_master{.fd = master_fd_, .events = POLLOUT, .revents = 0};
  side.open = poll(&poll_master, 1, 0) >= 0 && (poll_master.revents & POLLHUP) == 0;
  termios settings{};
  if (tcgetattr(master_fd_, &settings) != 0) return side;
  side.baud_bps = BaudOf(cfgetospeed(&settings));
  side.parity = (settings.c_cflag & PARENB) != 0;
  return side;
}

std::size_t Pty::Write(std::span<const std::uint8_t> bytes) {
  std::size_t done = 0;
  while (plugged() && done < bytes.size()) {
    const ssize_t n = write(master_fd_, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    done += static_cast<std::size_t>(n);
  }
  return done;
}

std::size_t Pty::Read(std::span<std::uint8_t> bytes) {
  while (plugged()) {
    const ssize_t n = read(master_fd_, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    return n > 0 ? static_cast<std::size_t>(n) : 0;  // EAGAIN: nothing; EIO: nobody has it open
  }
  return 0;
}

}  // namespace kawara::sim
