#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/expected.hpp"
#include "vision/image.hpp"

namespace kawara::vision {

/// Largest picture taken. Checked on the header, before memory is asked for.
constexpr std::int64_t kMaxPngPixels = 100'000'000;

/// A picture that owns its pixels: packed RGB8, rows from the top.
struct RgbPicture {
  std::vector<std::uint8_t> rgb;
  int width_px = 0;
  int height_px = 0;
  ConstImageView view() const { return {rgb.data(), width_px, height_px}; }
};

/// Numbers as a picture, rows from the top: millimetres, for example.
struct Grey16Picture {
  std::vector<std::uint16_t> level;
  int width_px = 0;
  int height_px = 0;
};

// PNG by libpng (ISO/IEC 15948). Whole files in memory; any thread. Whatever the bytes are, the
// answer of the readers is a whole picture or kFormat: damage, another picture than asked for, more
// pixels than `max_pixels`, or more than the file's bytes can hold.

/// Any PNG as RGB8: grey three times the same, of 16 bits the upper 8 (of the lower 10, 12 or 14 if
/// no level is larger and the file does not state its bits), a palette's colours, transparency left
/// out, no gamma applied.
core::Expected<RgbPicture> DecodePng(std::span<const std::uint8_t> png,
                                     std::int64_t max_pixels = kMaxPngPixels);
/// Only a grey PNG of 16 bits without transparency: its numbers as they are.
core::Expected<Grey16Picture> DecodeGrey16Png(std::span<const std::uint8_t> png,
                                              std::int64_t max_pixels = kMaxPngPixels);

/// How hard deflate tries, 1 (fast) to 9 (small). The pixels are the same.
constexpr int kPngFast = 2, kPngSmall = 9;

/// kInvalidArgument: empty picture, or one whose vector is not of its size.
core::Expected<std::vector<std::uint8_t>> EncodePng(const ConstImageView& picture, int effort);
core::Expected<std::vector<std::uint8_t>> EncodePng(const Grey16Picture& picture, int effort);

}  // namespace kawara::vision
