#pragma once
#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "sim/faults/fault_command.hpp"
#include "sim/faults/faults.hpp"
#include "sim/radio/radio_relay.hpp"

namespace kawara::sim {

/// Everything `kawara-sim radio` can be told.
struct RadioRunOptions {
  RadioRelayOptions relay;
  std::optional<double> duration_s;                    ///< none: until stopped
  std::vector<Fault> faults;                           ///< counted from the start of the radio
  std::string command_channel = kDefaultFaultChannel;  ///< of orders, on the robot's bus
};

/// Carries two LCM buses across a simulated radio until the time is up or `stop`; takes orders of
/// radio faults meanwhile (FaultListener). Prints one line
/// when it hears both. Blocks. Errors: those of RadioRelay::Open; a fault that is none of a radio.
core::Expected<RadioSummary> RunRadio(const RadioRunOptions& options,
                                      const std::atomic<bool>& stop);

}  // namespace kawara::sim
