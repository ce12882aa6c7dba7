#include "drivers/v4l2_pixels.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "drivers/v4l2_bayer.hpp"

namespace kawara::drivers {
namespace {

/// Coefficients of YCbCr to RGB, times 2^16.
struct YuvMatrix {
  int y_offset = 0;
  int y = 0, r_cr = 0, g_cb = 0, g_cr = 0, b_cb = 0;
};

/// From the weights of red and blue in luma: ITU-R BT.601-7 section 2.5, BT.709-6 section 3.
YuvMatrix MatrixFor(bool bt709, bool full_range) {
  const double kr = bt709 ? 0.2126 : 0.299, kb = bt709 ? 0.0722 : 0.114;
  const double kg = 1.0 - kr - kb;
  const double y_scale = full_range ? 1.0 : 255.0 / 219.0;
  const double c = full_range ? 1.0 : 255.0 / 224.0;
  const auto fixed = [](double value) { return static_cast<int>(std::lround(value * 65536.0)); };
  return {full_range ? 0 : 16,
          fixed(y_scale),
          fixed(2.0 * (1.0 - kr) * c),
          fixed(2.0 * (1.0 - kb) * kb / kg * c),
          fixed(2.0 * (1.0 - kr) * kr / kg * c),
          fixed(2.0 * (1.0 - kb) * c)};
}

std::uint8_t Clamped(int value) {
  return static_cast<std::uint8_t>(std::clamp(value >> 16, 0, 255));
}

void PutRgb(const YuvMatrix& m, int y, int cb, int cr, std::uint8_t* rgb) {
  const int luma = (y - m.y_offset) * m.y + (1 << 15);
  cb -= 128;
  cr -= 128;
  rgb[0] = Clamped(luma + m.r_cr * cr);
  rgb[1] = Clamped(luma - m.g_cb * cb - m.g_cr * cr);
  rgb[2] = Clamped(luma + m.b_cb * cb);
}

void FromYuyv(const V4l2PictureFormat& f, const std::uint8_t* from, std::uint8_t* to) {
  const YuvMatrix m = MatrixFor(f.bt709, f.full_range);
  for (std::uint32_t row = 0; row < f.height_px; ++row) {
    const std::uint8_t* p = from + std::size_t{row} * f.stride_bytes;
    for (std::uint32_t column = 0; column < f.width_px; column += 2, p += 4, to += 6) {
      PutRgb(m, p[0], p[1], p[3], to);
      PutRgb(m, p[2], p[1], p[3], to + 3);
    }
  }
}

void FromNv12(const V4l2PictureFormat& f, const std::uint8_t* from, std::uint8_t* to) {
  const YuvMatrix m = MatrixFor(f.bt709, f.full_range);
  const std::uint8_t* const chroma = from + std::size_t{f.stride_bytes} * f.height_px;
  for (std::uint32_t row = 0; row < f.height_px; ++row) {
    const std::uint8_t* const y = from + std::size_t{row} * f.stride_bytes;
    const std::uint8_t* const c = chroma + std::size_t{row / 2} * f.stride_bytes;
    for (std::uint32_t column = 0; column < f.width_px; ++column, to += 3) {
      const std::uint32_t pair = column & ~1U;
      PutRgb(m, y[column], c[pair], c[pair + 1], to);
    }
  }
}

void FromGrey(const V4l2PictureFormat& f, const std::uint8_t* from, std::uint8_t* to) {
  for (std::uint32_t row = 0; row < f.height_px; ++row) {
    to = std::copy_n(from + std::size_t{row} * f.stride_bytes, f.width_px, to);
  }
}

std::uint32_t BytesOfRow(V4l2Layout layout, std::uint32_t width_px) {
  return layout == V4l2Layout::kYuyv ? 2 * width_px : width_px;
}

}  // namespace

std::size_t V4l2PictureBytes(const V4l2PictureFormat& format) {
  const V4l2PixelFormat* const known = FindV4l2PixelFormat(format.fourcc);
  if (known == nullptr || known->layout == V4l2Layout::kMotionJpeg || format.height_px == 0) {
    return 0;
  }
  std::size_t rows = format.height_px;
  if (known->layout == V4l2Layout::kNv12) rows += format.height_px / 2;
  return (rows - 1) * format.stride_bytes + BytesOfRow(known->layout, format.width_px);
}

core::Expected<V4l2Pixels> ConvertV4l2Pixels(const V4l2PictureFormat& format,
                                             std::span<const std::uint8_t> bytes) {
  const std::size_t needed = V4l2PictureBytes(format);
  if (needed == 0) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      FourccText(format.fourcc) + " is not a raw format that is taken");
  }
  const V4l2Layout layout = FindV4l2PixelFormat(format.fourcc)->layout;
  const bool even = layout == V4l2Layout::kYuyv ? format.width_px % 2 == 0
                    : layout == V4l2Layout::kNv12
                        ? format.width_px % 2 == 0 && format.height_px % 2 == 0
                        : true;
  const bool raster =
      layout != V4l2Layout::kBayer || (format.width_px >= 2 && format.height_px >= 2);
  if (!even || !raster || format.width_px == 0 ||
      format.stride_bytes < BytesOfRow(layout, format.width_px)) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      FourccText(format.fourcc) + " of " + std::to_string(format.width_px) + "x" +
                          std::to_string(format.height_px) + " in rows of " +
                          std::to_string(format.stride_bytes) + " bytes makes no sense");
  }
  if (bytes.size() < needed) {
    return core::Fail(core::ErrorCode::kFormat, "frame of " + std::to_string(bytes.size()) +
                                                    " bytes where " + FourccText(format.fourcc) +
                                                    " needs " + std::to_string(needed));
  }
  V4l2Pixels pixels;
  const std::size_t area = std::size_t{format.width_px} * format.height_px;
  if (layout == V4l2Layout::kGrey) {
    pixels.format = PixelFormat::kGrey8;
    pixels.bytes.resize(area);
    FromGrey(format, bytes.data(), pixels.bytes.data());
    return pixels;
  }
  pixels.bytes.resize(3 * area);
  if (layout == V4l2Layout::kYuyv) FromYuyv(format, bytes.data(), pixels.bytes.data());
  if (layout == V4l2Layout::kNv12) FromNv12(format, bytes.data(), pixels.bytes.data());
  if (layout == V4l2Layout::kBayer) RgbFromBayer(format, bytes.data(), pixels.bytes.data());
  return pixels;
}

}  // namespace kawara::drivers
