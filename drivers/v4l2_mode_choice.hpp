#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "drivers/v4l2_formats.hpp"

namespace kawara::drivers {

/// What is asked of a camera.
struct V4l2ModeWish {
  std::uint32_t width_px = 0;  ///< 0 with height 0: as large as the rate allows
  std::uint32_t height_px = 0;
  double rate_hz = 10.0;  ///< at least
  std::string format;     ///< one of V4l2PixelFormats(); empty: the preferred one
};

struct V4l2Mode {
  std::uint32_t fourcc = 0;
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  V4l2Interval interval;  ///< not known: the device does not say
  bool operator==(const V4l2Mode&) const = default;
};

/// "MJPG 1920x1080 at 30 Hz".
std::string TextOf(const V4l2Mode& mode);

/// Of all modes with the format and size wished (where wished) and at least the wished rate: the
/// largest area, then the format that stands first in V4l2PixelFormats(), then the slowest rate
/// (what is not needed only costs bus and processor). A device that does not tell its rates is
/// taken to reach any. Of a raster of sizes the largest is taken.
///
/// kInvalidArgument if there is none: what was asked for and all that the device offers.
core::Expected<V4l2Mode> ChooseV4l2Mode(const std::vector<V4l2FormatOffer>& offers,
                                        const V4l2ModeWish& wish);

}  // namespace kawara::drivers
