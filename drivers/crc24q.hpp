#pragma once
#include <cstdint>
#include <span>

namespace kawara::drivers {

/// CRC-24Q as RTCM 3 uses it: generator 0x1864CFB, start value 0, most significant bit first, no
/// final XOR. `crc` continues a sum over bytes that came before, so a frame may be summed in
/// pieces. The sum over a whole frame including its three CRC bytes is 0. Eight bytes a step from
/// tables built at compile time. Real-time safe, any thread. Source: RTCM 10403, section "transport
/// layer".
std::uint32_t Crc24q(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0) noexcept;

}  // namespace kawara::drivers
