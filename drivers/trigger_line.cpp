#include "drivers/trigger_line.hpp"

#include <time.h>

#include "drivers/gpio_line.hpp"
#include "drivers/modem_line.hpp"

namespace kawara::drivers {

core::Expected<void> TriggerLine::Pulse(core::Duration length) {
  const std::int64_t end_ns = (core::MonoNow() + length).ns();
  if (auto on = Set(true); !on) return on;
  const timespec end{end_ns / 1'000'000'000, end_ns % 1'000'000'000};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &end, nullptr) != 0) {
  }
  return Set(false);
}

core::Expected<std::unique_ptr<TriggerLine>> OpenTriggerLine(const TriggerLineConfig& config) {
  switch (config.kind) {
    case TriggerLineConfig::Kind::kGpio:
      return GpioLine::Open(config);
    case TriggerLineConfig::Kind::kRts:
    case TriggerLineConfig::Kind::kDtr:
      return ModemLine::Open(config);
    case TriggerLineConfig::Kind::kNone:
      break;
  }
  return core::Fail(core::ErrorCode::kInvalidArgument, "trigger line: none is configured");
}

}  // namespace kawara::drivers
