#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "drivers/pps_socket_client.hpp"

/// The byte stream of a pulse socket, in pieces of the size that the input's first byte chooses:
/// never a crash, never a stamp from the future or from before the clock's zero.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  const kawara::core::MonoTime now = kawara::core::MonoTime::FromNs(std::int64_t{1} << 60);
  const std::size_t piece = 1 + data[0];
  kawara::drivers::PpsEdgeAssembler assembler;
  for (std::size_t at = 1; at < size; at += piece) {
    std::span<const std::uint8_t> rest(data + at, std::min(piece, size - at));
    while (!rest.empty()) {
      const std::size_t before = rest.size();
      const auto edge = assembler.Feed(now, rest);
      if (rest.size() >= before) std::abort();  // no progress
      if (!edge) {
        assembler.Reset();
      } else if (*edge &&
                 ((*edge)->mono.ns() <= 0 || (*edge)->mono > now + kawara::drivers::kPpsFuture)) {
        std::abort();
      }
    }
  }
  return 0;
}
