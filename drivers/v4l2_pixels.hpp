#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/expected.hpp"
#include "drivers/camera.hpp"
#include "drivers/v4l2_device.hpp"

namespace kawara::drivers {

/// The picture of a raw buffer as the rest of the robot takes it.
struct V4l2Pixels {
  PixelFormat format = PixelFormat::kRgb8;
  std::vector<std::uint8_t> bytes;  ///< packed rows, 3 bytes a pixel, or 1 (kGrey8)
};

/// NV12, YUYV and the four 8-bit Bayer rasters to RGB8, GREY to Grey8; rows with padding (stride)
/// are taken. YCbCr by the matrix (BT.601, BT.709) and range the device states, in integers, to
/// within 1 of the exact value; chroma samples stand for the pixels they cover. Bayer by averages
/// of the nearest samples of each colour (v4l2_bayer.hpp). No gamma, no white
/// balance: the sensor's numbers.
///
/// kFormat: fewer bytes than the format needs (a frame that was cut off). kInvalidArgument: a
/// format that is not raw, or a size such a format cannot have. Pure; any thread.
core::Expected<V4l2Pixels> ConvertV4l2Pixels(const V4l2PictureFormat& format,
                                             std::span<const std::uint8_t> bytes);

/// Bytes that a picture of this raw format has at least; 0: a compressed or unknown format.
std::size_t V4l2PictureBytes(const V4l2PictureFormat& format);

}  // namespace kawara::drivers
