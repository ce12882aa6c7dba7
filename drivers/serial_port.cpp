#include "drivers/serial_port.hpp"

#include <fcntl.h>
#include <linux/serial.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "drivers/serial_diagnosis.hpp"
#include "drivers/serial_line.hpp"

namespace kawara::drivers {
namespace {

/// Unix98 pseudo-terminals (Linux Documentation/admin-guide/devices.txt: majors 136-143).
bool IsPseudoTerminal(int fd) {
  struct stat info {};
  if (fstat(fd, &info) != 0) return false;
  const unsigned device_major = major(info.st_rdev);
  return device_major >= 136 && device_major <= 143;
}

int BitsPerCharacter(SerialFormat format) { return format == SerialFormat::k8N1 ? 10 : 11; }

/// Short enough for std::string's own buffer: reading a dead port does not allocate.
tl::unexpected<core::Error> Gone() {
  return core::Fail(core::ErrorCode::kUnavailable, "unplugged");
}

}  // namespace

core::MonoTime DateFirstByte(std::size_t bytes, core::MonoTime line_empty_at, core::MonoTime woke,
                             core::MonoTime read_done, core::Duration character_time) {
  const auto behind = static_cast<std::int64_t>(bytes > 0 ? bytes - 1 : 0);
  core::MonoTime stamp = read_done - behind * character_time;
  if (woke.IsSet()) stamp = std::min(stamp, woke);
  return std::max(stamp, line_empty_at);
}

core::Expected<SerialPort> SerialPort::Open(const SerialConfig& config) {
  struct stat info {};
  // Look before opening: opening a pipe or a file can have effects of its own.
  if (stat(config.device.c_str(), &info) != 0) {
    return tl::unexpected(OpenError(config.device, errno));
  }
  if (!S_ISCHR(info.st_mode)) return tl::unexpected(NotSerialError(config.device));
  const int fd = open(config.device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return tl::unexpected(OpenError(config.device, errno));
  SerialPort port(fd, config);
  if (const auto configured = port.Configure(); !configured)
    return tl::unexpected(configured.error());
  return port;
}

SerialPort::SerialPort(int fd, SerialConfig config) : fd_(fd), config_(std::move(config)) {}

SerialPort::SerialPort(SerialPort&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      config_(std::move(other.config_)),
      granted_(other.granted_),
      character_time_(other.character_time_),
      line_empty_at_(other.line_empty_at_),
      first_byte_(other.first_byte_) {}

SerialPort& SerialPort::operator=(SerialPort&& other) noexcept {
  if (this == &other) return *this;
  Close();
  fd_ = std::exchange(other.fd_, -1);
  config_ = std::move(other.config_);
  granted_ = other.granted_;
  character_time_ = other.character_time_;
  line_empty_at_ = other.line_empty_at_;
  first_byte_ = other.first_byte_;
  return *this;
}

SerialPort::~SerialPort() { Close(); }

void SerialPort::Close() {
  if (fd_ < 0) return;
  // Unsent bytes would keep close() waiting for a device that takes no more (closing_wait, 30 s).
  tcflush(fd_, TCIOFLUSH);
  close(fd_);
  fd_ = -1;
}

core::Expected<void> SerialPort::Configure() {
  const std::string& device = config_.device;
  if (isatty(fd_) == 0) {
    return tl::unexpected(errno == EIO ? OpenError(device, EIO) : NotSerialError(device));
  }
  // First the lock: until it is ours, nothing on the line may be changed.
  if (flock(fd_, LOCK_EX | LOCK_NB) != 0) return tl::unexpected(OpenError(device, errno));
  granted_.pseudo_terminal = IsPseudoTerminal(fd_);
  // On a pseudo-terminal the mark would outlive a killed holder for as long as the other end is
  // open, and lock everybody out; flock dies with its holder.
  if (!granted_.pseudo_terminal) ioctl(fd_, TIOCEXCL);

  const auto line = SetLine(fd_, config_.baud_bps, config_.format);
  if (!line) {
    // EIO: ttyS without a UART behind it.
    if (line.error().code == core::ErrorCode::kIo) return tl::unexpected(OpenError(device, EIO));
    return core::Fail(line.error().code, "open " + device + ": " + line.error().message);
  }
  granted_.baud_bps = line->baud_bps;
  granted_.format = line->format;
  if (config_.low_latency) granted_.low_latency = SetLowLatency(fd_);
  int lines = 0;
  granted_.modem_lines = ioctl(fd_, TIOCMGET, &lines) == 0;
  character_time_ =
      core::Duration(BitsPerCharacter(granted_.format) * 1'000'000'000LL / granted_.baud_bps);
  DiscardInput();
  return {};
}

core::Expected<std::size_t> SerialPort::Read(std::span<std::uint8_t> buffer, core::MonoTime woke) {
  if (fd_ < 0) return Gone();
  const core::MonoTime before = core::MonoNow();
  const ssize_t n = read(fd_, buffer.data(), buffer.size());
  if (n < 0) {
    if (errno == EAGAIN || errno == EINTR) {
      if (errno == EAGAIN) line_empty_at_ = before;
      return 0;
    }
    return Gone();  // EIO, ENXIO, ENODEV: there is nothing to read from any more, whatever the
                    // number
  }
  if (n == 0) return buffer.empty() ? core::Expected<std::size_t>(0) : Gone();
  const auto size = static_cast<std::size_t>(n);
  const bool on_wire = config_.stamp == StampRule::kLineRate ||
                       (config_.stamp == StampRule::kAuto && !granted_.pseudo_terminal);
  const core::Duration spacing = on_wire ? character_time_ : core::Duration(0);
  const core::MonoTime done = core::MonoNow();
  std::size_t behind = size;
  if (size == buffer.size()) {
    // More may be waiting; those bytes, too, left the wire after our first one.
    int waiting = 0;
    if (ioctl(fd_, FIONREAD, &waiting) == 0 && waiting > 0)
      behind += static_cast<std::size_t>(waiting);
  }
  first_byte_ = DateFirstByte(behind, line_empty_at_, woke, done, spacing);
  // A full buffer may have left bytes behind; those came after the ones read now.
  line_empty_at_ =
      size < buffer.size() ? before : first_byte_ + static_cast<std::int64_t>(size) * spacing;
  return size;
}

core::Expected<std::size_t> SerialPort::Write(std::span<const std::uint8_t> bytes) {
  if (fd_ < 0) return Gone();
  if (bytes.empty()) return 0;
  const ssize_t n = write(fd_, bytes.data(), bytes.size());
  if (n >= 0) return static_cast<std::size_t>(n);
  if (errno == EAGAIN || errno == EINTR) return 0;
  return Gone();
}

core::Expected<void> SerialPort::SetBaud(int baud_bps) {
  const auto line = SetLine(fd_, baud_bps, config_.format);
  if (!line) return core::Fail(line.error().code, config_.device + ": " + line.error().message);
  config_.baud_bps = baud_bps;
  granted_.baud_bps = line->baud_bps;
  granted_.format = line->format;
  character_time_ =
      core::Duration(BitsPerCharacter(granted_.format) * 1'000'000'000LL / granted_.baud_bps);
  // What was received at the old rate is noise at the new one.
  DiscardInput();
  return {};
}

core::Expected<void> SerialPort::SetModemLines(std::optional<bool> rts, std::optional<bool> dtr) {
  int raise = 0;
  int drop = 0;
  if (rts) (*rts ? raise : drop) |= TIOCM_RTS;
  if (dtr) (*dtr ? raise : drop) |= TIOCM_DTR;
  if ((raise != 0 && ioctl(fd_, TIOCMBIS, &raise) != 0) ||
      (drop != 0 && ioctl(fd_, TIOCMBIC, &drop) != 0)) {
    return core::Fail(core::ErrorCode::kUnavailable, "no RTS/DTR");
  }
  return {};
}

std::optional<SerialLineErrors> SerialPort::LineErrors() const {
  serial_icounter_struct counts{};
  if (ioctl(fd_, TIOCGICOUNT, &counts) != 0) return std::nullopt;
  const auto of = [](int count) { return static_cast<std::uint32_t>(count); };
  return SerialLineErrors{of(counts.frame), of(counts.parity), of(counts.overrun),
                          of(counts.buf_overrun), of(counts.brk)};
}

void SerialPort::DiscardInput() {
  tcflush(fd_, TCIFLUSH);
  line_empty_at_ = core::MonoNow();
}

}  // namespace kawara::drivers
