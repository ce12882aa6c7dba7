#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/expected.hpp"

namespace kawara::drivers {

/// A camera's MJPEG frame made a JPEG file of its own: what follows the end of image (padding up to
/// the transfer's size) is left out, and the Huffman tables that cameras commonly omit are put in
/// (ITU-T T.81, annex K.3), without which few viewers show the picture. The picture itself is
/// neither decoded nor changed.
struct MotionJpeg {
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  std::vector<std::uint8_t> bytes;
};

/// kFormat: no JPEG, no size before the picture, or cut off before its end (a frame damaged on the
/// bus). Pure; whatever the bytes are; any thread.
core::Expected<MotionJpeg> ReadMotionJpeg(std::span<const std::uint8_t> frame);

}  // namespace kawara::drivers
