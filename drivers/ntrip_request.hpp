#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "core/expected.hpp"
#include "core/measurements.hpp"
#include "core/time.hpp"

/// What a client says to an NTRIP caster. Source: RTCM 10410.0 (version 1) and 10410.1 (version 2).
namespace kawara::drivers {

constexpr std::uint16_t kNtripPort = 2101;

struct NtripRequest {
  std::string host;
  std::uint16_t port = kNtripPort;
  std::string mountpoint;  ///< empty asks for the list of mountpoints
  std::string user;        ///< empty: no Authorization
  std::string password;
  int version = 2;  ///< 1 or 2; a version 1 caster answers a version 2 request in its own way
  std::string gga;  ///< a $..GGA sentence for the Ntrip-GGA header of version 2, without CR LF; may
                    ///< be empty
};

/// The whole request, blank line included. kInvalidArgument: no host, control characters or spaces
/// where they would break the request apart, a colon in the user's name, a version that does not
/// exist.
core::Expected<std::string> MakeNtripRequest(const NtripRequest& request);

/// $GPGGA of a fix, with checksum, without CR LF, as casters want it for a network solution: height
/// above the geoid if the separation is known, else ellipsoidal height and no separation. Empty if
/// the fix has no position.
std::optional<std::string> MakeGga(const core::GnssFix& fix, const core::LeapSeconds& leaps = {});

}  // namespace kawara::drivers
