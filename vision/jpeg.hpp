#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "core/expected.hpp"
#include "vision/image.hpp"
#include "vision/yuv420.hpp"

namespace kawara::vision {

/// Largest picture taken or made. Checked on the header, before memory is asked for.
constexpr std::int64_t kMaxJpegPixels = 100'000'000;

struct JpegOptions {
  int quality = 85;  ///< 1..100, libjpeg's scale
  /// false: baseline with a restart marker after every row of blocks (16 px), so that a hole in the
  /// bytes costs only the rows it hit. true: progressive, so that any prefix shows the whole
  /// picture coarsely; no restarts.
  bool progressive = false;
};

/// RGB8 or YCbCr 4:2:0 to JPEG, YCbCr 4:2:0 (libjpeg-turbo). The output buffer and the compressor
/// are kept: pictures not larger than an earlier one allocate no new output memory. One thread.
class JpegEncoder {
 public:
  JpegEncoder();
  ~JpegEncoder();
  JpegEncoder(JpegEncoder&&) noexcept;
  JpegEncoder& operator=(JpegEncoder&&) noexcept;

  /// The bytes live in the encoder until the next call. kInvalidArgument: empty or too large
  /// picture.
  core::Expected<std::span<const std::uint8_t>> Encode(const ConstImageView& picture,
                                                       const JpegOptions& options);
  /// The same from planes, without colour conversion. Fills their margin, which the last blocks
  /// take in.
  core::Expected<std::span<const std::uint8_t>> EncodeYuv420(const Yuv420View& picture,
                                                             const JpegOptions& options);
  std::size_t buffer_bytes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

struct JpegInfo {
  int width_px = 0;
  int height_px = 0;
  bool progressive = false;
};

struct JpegDecodeOptions {
  int scale_eighths = 8;  ///< 1..8: reduces to width * scale / 8, rounded up, while decoding
  /// Take a picture with damaged or missing parts (they come out grey or wrong) instead of failing.
  bool accept_damage = false;
  std::int64_t max_pixels = kMaxJpegPixels;
};

/// JPEG (baseline or progressive; grey or colour) to RGB8 or YCbCr 4:2:0. Pixel memory is kept
/// between calls and only grows. Never crashes on what it is given: truncated, corrupt or absurd
/// files are kFormat. One thread.
class JpegDecoder {
 public:
  JpegDecoder();
  ~JpegDecoder();
  JpegDecoder(JpegDecoder&&) noexcept;
  JpegDecoder& operator=(JpegDecoder&&) noexcept;

  /// Header only: cheap.
  core::Expected<JpegInfo> ReadInfo(std::span<const std::uint8_t> jpeg,
                                    std::int64_t max_pixels = kMaxJpegPixels);
  /// The pixels live in the decoder until the next call.
  core::Expected<ConstImageView> Decode(std::span<const std::uint8_t> jpeg,
                                        const JpegDecodeOptions& options = {});
  /// The whole picture (scale_eighths is not looked at) as planes. A YCbCr 4:2:0 file's samples
  /// come as they are; any other goes through RGB. Errors and lifetime as with Decode. The margin
  /// continues the picture.
  core::Expected<ConstYuv420View> DecodeYuv420(std::span<const std::uint8_t> jpeg,
                                               const JpegDecodeOptions& options = {});
  /// Damage the last Decode met and accepted: libjpeg's count of warnings.
  long warnings() const;
  std::size_t buffer_bytes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Largest reduction (smallest eighths) that still leaves at least `wanted_px` of `width_px`.
int ScaleEighthsFor(int width_px, int wanted_px);

}  // namespace kawara::vision
