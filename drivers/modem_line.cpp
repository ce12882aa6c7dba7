#include "drivers/modem_line.hpp"

namespace kawara::drivers {

core::Expected<std::unique_ptr<TriggerLine>> ModemLine::Open(const TriggerLineConfig& config) {
  SerialConfig serial;
  serial.device = config.device;
  serial.low_latency = false;  // nothing is read
  auto port = SerialPort::Open(serial);
  if (!port) {
    port.error().message = "trigger: " + port.error().message;
    return tl::unexpected(port.error());
  }
  if (!port->granted().modem_lines) {
    return core::Fail(
        core::ErrorCode::kInvalidArgument,
        "trigger: " + config.device + " has no RTS and DTR that could be set (a pseudo-terminal?)");
  }
  std::unique_ptr<ModemLine> line(new ModemLine(
      std::move(*port), config.kind == TriggerLineConfig::Kind::kRts, config.active_low));
  if (auto rest = line->Set(false); !rest) return tl::unexpected(rest.error());
  return line;
}

core::Expected<void> ModemLine::Set(bool active) {
  const bool raised = active != active_low_;
  auto set = rts_ ? port_.SetModemLines(raised, {}) : port_.SetModemLines({}, raised);
  if (!set) set.error().message = "trigger: " + set.error().message;
  return set;
}

}  // namespace kawara::drivers
