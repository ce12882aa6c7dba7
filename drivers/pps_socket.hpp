#pragma once
#include <cstdint>

/// Wire format between the simulated pulse line (server, sim/) and drivers::SocketPps (client),
/// over a UNIX stream socket on one machine: nothing but these records, one an edge, as they
/// happen. All fields little-endian, packed as declared. Stamps are CLOCK_MONOTONIC of the shared
/// machine. Why a socket: no program can raise a kernel PPS or a modem line of a pseudo-terminal.
namespace kawara::drivers {

constexpr std::uint32_t kPpsEdgeMagic = 0x5350504bU;  ///< "KPPS"

struct PpsEdgeMessage {
  std::uint32_t magic = kPpsEdgeMagic;
  std::uint32_t sequence = 0;
  std::int64_t mono_ns = 0;
};
static_assert(sizeof(PpsEdgeMessage) == 16);

}  // namespace kawara::drivers
