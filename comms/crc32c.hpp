#pragma once
#include <cstdint>
#include <span>

namespace kawara::comms {

/// CRC-32C (Castagnoli, as in iSCSI: polynomial 0x1EDC6F41 reflected, start and end inverted).
/// Source: RFC 3720, section 12.1 and appendix B.4. `crc` continues an earlier result: Crc32c(b,
/// Crc32c(a)) is that of a then b. Uses the processor's instruction where there is one (x86-64 with
/// SSE4.2, found at run time).
std::uint32_t Crc32c(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0);

namespace internal {
std::uint32_t Crc32cPortable(std::span<const std::uint8_t> bytes, std::uint32_t crc);
}

}  // namespace kawara::comms
