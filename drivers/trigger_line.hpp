#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "core/expected.hpp"
#include "core/time.hpp"

namespace kawara::drivers {

/// The wire a camera's trigger input hangs on.
struct TriggerLineConfig {
  enum class Kind : std::uint8_t { kNone, kGpio, kRts, kDtr };
  Kind kind = Kind::kNone;
  std::string device;  ///< GPIO chip ("gpiochip0", its path or label) or the serial port
  std::string line;    ///< GPIO: its offset on the chip, or its name
  bool active_low = false;
  core::Duration pulse = core::Milliseconds(1);  ///< how long it stays active
};

/// An output held by us alone, at rest from its opening to its end. One thread.
class TriggerLine {
 public:
  virtual ~TriggerLine() = default;
  /// Errors: kUnavailable (unplugged), kIo.
  virtual core::Expected<void> Set(bool active) = 0;
  /// Active for `length`, measured by CLOCK_MONOTONIC; sleeps meanwhile.
  core::Expected<void> Pulse(core::Duration length);
};

/// Errors, one line with its cure: kNotFound (no such chip, port or line), kPermission,
/// kUnavailable (in use, and by whom if that is told), kInvalidArgument (a port without modem
/// lines, kind kNone).
core::Expected<std::unique_ptr<TriggerLine>> OpenTriggerLine(const TriggerLineConfig& config);

}  // namespace kawara::drivers
