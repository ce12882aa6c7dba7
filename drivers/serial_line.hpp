#pragma once
#include "drivers/serial_port.hpp"

/// The termios side of SerialPort: settings in, what was granted out. Knows no files and no stamps.
namespace kawara::drivers {

/// Raw mode at `baud_bps` and `format`, then read back. kInvalidArgument when the rate cannot be
/// made (granted rate more than 3 % off: an UART does not survive more). Parity that did not stick
/// is no error: it shows in the result.
core::Expected<SerialGranted> SetLine(int fd, int baud_bps, SerialFormat format);
/// ASYNC_LOW_LATENCY; false where the driver does not know it.
bool SetLowLatency(int fd);

/// Rates without a termios name go through the kernel's termios2 (BOTHER). False: refused, see
/// errno.
bool SetArbitraryBaud(int fd, int baud_bps);
/// The real rate as the driver rounded it; 0 if it cannot be asked.
int GrantedBaud(int fd);

}  // namespace kawara::drivers
