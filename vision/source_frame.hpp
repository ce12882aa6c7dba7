#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "vision/jpeg.hpp"

namespace kawara::vision {

/// One exposure as the camera gave it (drivers::Frame without the driver).
struct SourceFrame {
  enum class Format : std::uint8_t { kJpeg, kRgb8 };
  Format format = Format::kJpeg;
  int width_px = 0;  ///< kRgb8 only
  int height_px = 0;
  std::span<const std::uint8_t> bytes;
};

/// "640 x 480 px", for messages.
std::string SizeText(int width_px, int height_px);

/// The pixels of a kRgb8 frame. kFormat: not as many bytes as its size says.
core::Expected<ConstImageView> RgbPixels(const SourceFrame& frame);

/// Frames as planes. The last one is remembered, with a copy of its bytes to know it by: the
/// preview and the full picture of a frame cost one decoding, and still what comes out depends on
/// nothing but what goes in. Memory grows to the largest frame and is kept. One thread.
class FramePlanes {
 public:
  /// The planes live until the next call. kFormat: damaged.
  core::Expected<ConstYuv420View> Of(const SourceFrame& frame);

 private:
  core::Expected<ConstYuv420View> Decode(const SourceFrame& frame);

  JpegDecoder decoder_;
  Yuv420Buffer converted_;  ///< of a kRgb8 frame
  SourceFrame known_;       ///< without its bytes
  std::vector<std::uint8_t> known_bytes_;
  ConstYuv420View planes_;  ///< empty: no frame known
};

}  // namespace kawara::vision
