#pragma once
#include <string>
#include <vector>

#include "core/expected.hpp"

/// Why a serial port does not open, in words that mend it. Looks into /dev and /proc: slow threads
/// only.
namespace kawara::drivers {

/// Serial devices of this machine, by-id links first, then ttyUSB*, ttyACM*, ttyAMA*, ttyGPS-like
/// links; ttyS* only where hardware answers. Sorted within each kind.
std::vector<std::string> ListSerialPorts();

/// "kawara-onboard (process 1234)" or "" if /proc does not tell. `path` may be a link.
std::string WhoHolds(const std::string& path);

/// The one line for open(path) having failed with `errno_value`.
core::Error OpenError(const std::string& path, int errno_value);
/// The one line for a path that opens but is no serial port.
core::Error NotSerialError(const std::string& path);

}  // namespace kawara::drivers
