#pragma once
#include <string>

#include "core/expected.hpp"

namespace kawara::comms {

/// Would a UDP multicast datagram from this machine to this group reach this machine? Looks for a
/// route, at the interface it leads to, and sends itself one datagram (ttl 0, to a port of its
/// own). At most half a second. Errors: kUnavailable with the commands that mend it;
/// kInvalidArgument: not a multicast address.
[[nodiscard]] core::Expected<void> CheckMulticast(const std::string& group_address);

/// Largest receive buffer a socket may ask for (net.core.rmem_max) [bytes]; 0 if unknown.
long ReceiveBufferLimitBytes();

}  // namespace kawara::comms
