#pragma once
#include <memory>

#include "drivers/serial_port.hpp"
#include "drivers/trigger_line.hpp"

namespace kawara::drivers {

/// RTS or DTR of a serial port of its own as an output (TIOCMBIS, TIOCMBIC). The kernel raises both
/// when the port is opened and we drop ours at once: a camera sees one short pulse then, of which
/// nobody asked. At close the lines stay as they are. A USB adapter adds about a millisecond.
class ModemLine final : public TriggerLine {
 public:
  static core::Expected<std::unique_ptr<TriggerLine>> Open(const TriggerLineConfig& config);
  core::Expected<void> Set(bool active) override;

 private:
  ModemLine(SerialPort port, bool rts, bool active_low)
      : port_(std::move(port)), rts_(rts), active_low_(active_low) {}
  SerialPort port_;
  bool rts_;
  bool active_low_;
};

}  // namespace kawara::drivers
