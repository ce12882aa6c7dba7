#pragma once
#include "core/time.hpp"

/// What systemd is told of the program (Type=notify, WatchdogSec=; sd_notify(3)). Nothing happens
/// where the program was not started by it. Slow threads.
namespace kawara::onboard::service {

void SayReady();
void SayAlive();
void SayStopping();
/// How often SayAlive() must be called: half of WatchdogSec, at most `otherwise`; that where there
/// is no watchdog.
core::Duration AlivePeriod(core::Duration otherwise);

}  // namespace kawara::onboard::service
