#pragma once
#include <cstdint>

#include "drivers/v4l2_device.hpp"

namespace kawara::drivers {

/// RGB8 from one of the four 8-bit Bayer rasters: each missing colour is the rounded mean of its
/// nearest samples, of those that are inside the picture. `from`: rows of format.stride_bytes;
/// `to`: packed rows of 3 bytes a pixel. At least 2 x 2 px. Pure.
void RgbFromBayer(const V4l2PictureFormat& format, const std::uint8_t* from, std::uint8_t* to);

}  // namespace kawara::drivers
