#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kawara::drivers {

/// How the bytes of a picture lie.
enum class V4l2Layout : std::uint8_t { kMotionJpeg, kNv12, kYuyv, kBayer, kGrey };

/// A pixel format this driver takes. `name` is what configurations and people write.
struct V4l2PixelFormat {
  std::uint32_t fourcc = 0;
  const char* name = "";
  V4l2Layout layout = V4l2Layout::kMotionJpeg;
};

/// All that are taken, the preferred first: MJPEG costs the least on the way to the 1st update
/// (nothing is decoded), then what has the most colour for its bytes.
std::span<const V4l2PixelFormat> V4l2PixelFormats();
/// Null: not one of them.
const V4l2PixelFormat* FindV4l2PixelFormat(std::uint32_t fourcc);
const V4l2PixelFormat* FindV4l2PixelFormat(std::string_view name);
/// Names of all, "MJPG NV12 ...".
std::string V4l2PixelFormatNames();
/// "YUYV"; what is not printable as '.'.
std::string FourccText(std::uint32_t fourcc);

/// Time of one frame as the kernel counts it. 0/0: the device does not say.
struct V4l2Interval {
  std::uint32_t numerator = 0;
  std::uint32_t denominator = 0;
  bool known() const { return numerator != 0 && denominator != 0; }
  double rate_hz() const { return known() ? static_cast<double>(denominator) / numerator : 0.0; }
  bool operator==(const V4l2Interval&) const = default;
};

/// One size, or a raster of sizes (VIDIOC_ENUM_FRAMESIZES), with its frame rates.
struct V4l2SizeOffer {
  std::uint32_t min_width = 0, max_width = 0, step_width = 0;  ///< [px]; one size: min = max
  std::uint32_t min_height = 0, max_height = 0, step_height = 0;
  std::vector<V4l2Interval> intervals;  ///< empty: the device does not say
  bool any_rate_between = false;        ///< `intervals` are the two ends of a range

  bool Has(std::uint32_t width, std::uint32_t height) const;
};

struct V4l2FormatOffer {
  std::uint32_t fourcc = 0;
  std::string description;  ///< the device's own
  std::vector<V4l2SizeOffer> sizes;
};

/// "MJPG 1920x1080 30 15, 640x480 30; YUYV ...": on one line, cut after `max_sizes` a format.
std::string TextOf(const std::vector<V4l2FormatOffer>& offers, std::size_t max_sizes = 6);
/// "640x480", "32x32..4096x2160 in steps of 2x2".
std::string SizeText(const V4l2SizeOffer& size);
/// "30 15 7.5", "1..60", "?".
std::string RatesText(const V4l2SizeOffer& size);

}  // namespace kawara::drivers
