#pragma once
#include <cstdint>
#include <optional>

#include "core/expected.hpp"
#include "core/time.hpp"

namespace kawara::drivers {

/// One pulse of the receiver: the instant at which this machine noticed its edge.
struct PpsEdge {
  std::uint32_t sequence = 0;  ///< counted by whoever stamps; gaps are edges that were missed
  core::MonoTime mono;
};

/// Where pulse-per-second edges come from: the kernel's /dev/ppsN (drivers/pps_device.hpp) or
/// a socket (drivers/pps_socket_client.hpp). Shaped after the kernel's PPS_FETCH (RFC 2783,
/// time_pps_fetch): one blocking call with a timeout that gives the latest edge and its count; the
/// kernel's stamps are of CLOCK_REALTIME and are a reader's to bring over. One thread.
class PpsSource {
 public:
  virtual ~PpsSource() = default;
  /// Waits up to `timeout` for the next edge. Empty: none came ("no edge" is normal).
  /// Errors: kUnavailable when the source is gone; the next call tries to open it again.
  virtual core::Expected<std::optional<PpsEdge>> Next(core::Duration timeout) = 0;
};

}  // namespace kawara::drivers
