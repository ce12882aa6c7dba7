#include "drivers/serial_line.hpp"

#include <linux/serial.h>
#include <sys/ioctl.h>
#include <termios.h>

#include <array>
#include <cerrno>
#include <cstdlib>

namespace kawara::drivers {
namespace {

struct NamedRate {
  int baud_bps;
  speed_t name;
};
constexpr std::array<NamedRate, 30> kNamedRates{{
    {50, B50},           {75, B75},           {110, B110},         {134, B134},
    {150, B150},         {200, B200},         {300, B300},         {600, B600},
    {1200, B1200},       {1800, B1800},       {2400, B2400},       {4800, B4800},
    {9600, B9600},       {19200, B19200},     {38400, B38400},     {57600, B57600},
    {115200, B115200},   {230400, B230400},   {460800, B460800},   {500000, B500000},
    {576000, B576000},   {921600, B921600},   {1000000, B1000000}, {1152000, B1152000},
    {1500000, B1500000}, {2000000, B2000000}, {2500000, B2500000}, {3000000, B3000000},
    {3500000, B3500000}, {4000000, B4000000},
}};

const speed_t* FindName(int baud_bps) {
  for (const NamedRate& rate : kNamedRates) {
    if (rate.baud_bps == baud_bps) return &rate.name;
  }
  return nullptr;
}

void MakeRaw(termios& line, SerialFormat format) {
  cfmakeraw(&line);
  // CLOCAL: a carrier line that nobody wired must not hang us up. HUPCL off: RTS and DTR may be a
  // camera's trigger, closing must not pull them.
  line.c_cflag &=
      ~static_cast<tcflag_t>(HUPCL | CSTOPB | CRTSCTS | PARENB | PARODD | CMSPAR | CSIZE);
  line.c_cflag |= CLOCAL | CREAD | CS8;
  line.c_iflag &= ~static_cast<tcflag_t>(IXOFF | IXANY | INPCK | IGNPAR | PARMRK);
  if (format != SerialFormat::k8N1) {
    line.c_cflag |= PARENB;
    // A byte with wrong parity becomes 0: the decoder's checksum finds it at its right place.
    line.c_iflag |= INPCK;
  }
  if (format == SerialFormat::k8O1) line.c_cflag |= PARODD;
  // VMIN 1 tells "nothing now" (EAGAIN) from "hung up" (0); with VMIN 0 both read as 0.
  line.c_cc[VMIN] = 1;
  line.c_cc[VTIME] = 0;
}

SerialFormat FormatOf(const termios& line) {
  if ((line.c_cflag & PARENB) == 0) return SerialFormat::k8N1;
  return (line.c_cflag & PARODD) != 0 ? SerialFormat::k8O1 : SerialFormat::k8E1;
}

}  // namespace

const char* ToString(SerialFormat f) {
  switch (f) {
    case SerialFormat::k8N1:
      return "8N1";
    case SerialFormat::k8E1:
      return "8E1";
    case SerialFormat::k8O1:
      return "8O1";
  }
  return "?";
}

core::Expected<SerialGranted> SetLine(int fd, int baud_bps, SerialFormat format) {
  using core::ErrorCode;
  if (baud_bps < 50 || baud_bps > 4'000'000) {
    return core::Fail(ErrorCode::kInvalidArgument, "baud rate " + std::to_string(baud_bps) +
                                                       " is impossible: expected 50..4000000");
  }
  termios line{};
  if (tcgetattr(fd, &line) != 0) return tl::unexpected(core::ErrnoError("tcgetattr", errno));
  MakeRaw(line, format);
  const speed_t* name = FindName(baud_bps);
  // Where the rate has no name any named one stands in until SetArbitraryBaud.
  const speed_t speed = name != nullptr ? *name : speed_t{B38400};
  cfsetispeed(&line, speed);
  cfsetospeed(&line, speed);
  if (tcsetattr(fd, TCSANOW, &line) != 0) {
    return tl::unexpected(core::ErrnoError("tcsetattr", errno));
  }
  if (name == nullptr && !SetArbitraryBaud(fd, baud_bps)) {
    return tl::unexpected(core::ErrnoError("set " + std::to_string(baud_bps) + " baud", errno));
  }

  // tcsetattr succeeds when ANY part of the request was granted, so look what it was.
  termios granted_line{};
  if (tcgetattr(fd, &granted_line) != 0)
    return tl::unexpected(core::ErrnoError("tcgetattr", errno));
  SerialGranted granted;
  granted.format = FormatOf(granted_line);
  granted.baud_bps = GrantedBaud(fd);
  const long error_bps = std::labs(static_cast<long>(granted.baud_bps) - baud_bps);
  if (granted.baud_bps > 0 && error_bps * 100 > 3L * baud_bps) {
    return core::Fail(ErrorCode::kInvalidArgument, "baud rate " + std::to_string(baud_bps) +
                                                       " is not possible here: the driver offers " +
                                                       std::to_string(granted.baud_bps));
  }
  if (granted.baud_bps <= 0) granted.baud_bps = baud_bps;
  return granted;
}

bool SetLowLatency(int fd) {
  serial_struct serial{};
  if (ioctl(fd, TIOCGSERIAL, &serial) != 0) return false;
  constexpr int kLowLatency = static_cast<int>(ASYNC_LOW_LATENCY);
  serial.flags |= kLowLatency;
  if (ioctl(fd, TIOCSSERIAL, &serial) != 0) return false;
  return ioctl(fd, TIOCGSERIAL, &serial) == 0 && (serial.flags & kLowLatency) != 0;
}

}  // namespace kawara::drivers
