#include "onboard/service_manager.hpp"

#include <systemd/sd-daemon.h>

#include <algorithm>
#include <cstdint>

namespace kawara::onboard::service {

// A service manager that does not listen is its own trouble: the robot drives on.
void SayReady() { (void)sd_notify(0, "READY=1"); }
void SayAlive() { (void)sd_notify(0, "WATCHDOG=1"); }
void SayStopping() { (void)sd_notify(0, "STOPPING=1"); }

core::Duration AlivePeriod(core::Duration otherwise) {
  std::uint64_t limit_us = 0;
  if (sd_watchdog_enabled(0, &limit_us) <= 0) return otherwise;
  return std::min(otherwise, core::Duration(static_cast<std::int64_t>(limit_us) * 1000 / 2));
}

}  // namespace kawara::onboard::service
