#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "vision/stereo/range_image.hpp"

namespace kawara::mapper {

using Rgb = std::array<std::uint8_t, 3>;

/// The colour people see a range in: by inverse range from 1 m (red) to 20 m and more (blue),
/// black where unknown (NaN).
Rgb RangeColour(float range_m);

/// Packed RGB8, rows from the top, the image's size.
std::vector<std::uint8_t> RangeColours(const vision::RangeImage& ranges);

}  // namespace kawara::mapper
