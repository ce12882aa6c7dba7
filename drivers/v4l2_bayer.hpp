#pragma once
#include <cstdint>

#include "drivers/v4l2_device.hpp"

namespace kawara::drivers {

/// RGB8 from one of the four 8-bit Bayer rasters: each missing colour is the rounded mean of its
/// two or four nearest samples; at the border the raster is mirrored, which keeps every colour's
/// place. `from`: rows of format.stride_bytes; `to`: packed rows of 3 bytes a pixel. At least 2 x 2
/// px. Pure.
void RgbFromBayer(const V4l2PictureFormat& format, const std::uint8_t* from, std::uint8_t* to);

}  // namespace kawara::drivers
