// Alone in its file: the kernel's termios2 (<asm/termbits.h>) and glibc's <termios.h> define the
// same names.
#include <asm/ioctls.h>
#include <asm/termbits.h>
#include <sys/ioctl.h>

#include "drivers/serial_line.hpp"

namespace kawara::drivers {

bool SetArbitraryBaud(int fd, int baud_bps) {
  struct termios2 line {};
  if (ioctl(fd, TCGETS2, &line) != 0) return false;
  line.c_cflag &= ~static_cast<tcflag_t>(CBAUD | CIBAUD);
  line.c_cflag |= BOTHER;
  line.c_ispeed = static_cast<speed_t>(baud_bps);
  line.c_ospeed = static_cast<speed_t>(baud_bps);
  return ioctl(fd, TCSETS2, &line) == 0;
}

int GrantedBaud(int fd) {
  struct termios2 line {};
  return ioctl(fd, TCGETS2, &line) == 0 ? static_cast<int>(line.c_ospeed) : 0;
}

}  // namespace kawara::drivers
