#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "vision/image.hpp"

namespace kawara::vision {

/// Distance of the rows of a plane [bytes]. Whole JPEG blocks fit in, and one more: without it the
/// rows of a 2048 px plane would lie a power of two apart and push each other out of the cache.
constexpr std::size_t PlaneStrideBytes(int width_px) {
  return (static_cast<std::size_t>(width_px) + 15) / 16 * 16 + 16;
}

/// One plane of 8-bit samples, rows from the top, PlaneStrideBytes(width_px) bytes each. Right of
/// and below the picture lies a MARGIN up to whole blocks of 8 samples, which can be read and
/// written. Does not own the samples.
struct ConstPlaneView {
  const std::uint8_t* data = nullptr;
  int width_px = 0;
  int height_px = 0;

  std::size_t stride_bytes() const { return PlaneStrideBytes(width_px); }
  std::size_t size_bytes() const { return stride_bytes() * static_cast<std::size_t>(height_px); }
  const std::uint8_t* row(int v) const {
    return data + stride_bytes() * static_cast<std::size_t>(v);
  }
};

/// The same, writable.
struct PlaneView {
  std::uint8_t* data = nullptr;
  int width_px = 0;
  int height_px = 0;

  std::size_t stride_bytes() const { return PlaneStrideBytes(width_px); }
  std::size_t size_bytes() const { return stride_bytes() * static_cast<std::size_t>(height_px); }
  std::uint8_t* row(int v) const { return data + stride_bytes() * static_cast<std::size_t>(v); }
  operator ConstPlaneView() const {
    return {data, width_px, height_px};
  }  // NOLINT(google-explicit-constructor)
};

/// What black is in each plane: JFIF uses the full range 0..255 for luma, and 128 is "no colour".
constexpr std::uint8_t kBlackLuma = 0;
constexpr std::uint8_t kBlackChroma = 128;

/// A picture as JPEG files keep it: luma in full, the two colour differences in half the
/// resolution (rounded up). Full-range BT.601, as JFIF says. Chroma sample (i, j) stands for the
/// luma pixels 2i, 2i + 1 of the rows 2j, 2j + 1 and is CENTRED between them: a chroma plane is the
/// same picture at half the size, corner on corner. Source: JFIF 1.02, "Colour space" and "Spatial
/// relationship of components".
struct ConstYuv420View {
  ConstPlaneView y, cb, cr;
  int width_px() const { return y.width_px; }
  int height_px() const { return y.height_px; }
  bool empty() const { return y.data == nullptr || y.width_px <= 0 || y.height_px <= 0; }
};

/// The same, writable.
struct Yuv420View {
  PlaneView y, cb, cr;
  int width_px() const { return y.width_px; }
  int height_px() const { return y.height_px; }
  operator ConstYuv420View() const { return {y, cb, cr}; }  // NOLINT(google-explicit-constructor)
};

/// Memory for such a picture, kept between pictures; it only grows.
class Yuv420Buffer {
 public:
  /// Planes for a picture of this size. Views given out before are void; the contents are whatever
  /// was there.
  Yuv420View View(int width_px, int height_px);
  std::size_t capacity_bytes() const { return bytes_.capacity(); }

 private:
  std::vector<std::uint8_t> bytes_;
};

/// Repeats the last column and row of each plane over its margin.
void FillMargin(const Yuv420View& picture);

/// Colours as libjpeg computes them; chroma from the mean of its (up to) four pixels. The sizes
/// must be equal (CORE_CHECK). Fills the margin.
void Yuv420FromRgb(const ConstImageView& rgb, const Yuv420View& yuv);

/// Mean of every `factor` x `factor` samples (1, 2, 4 or 8) of each plane, rounded; sizes are those
/// of the source divided by it, rounded up (CORE_CHECK). Blocks that stick out take part of the
/// source's margin in. Fills the target's margin.
void ReduceYuv420(const ConstYuv420View& source, int factor, const Yuv420View& target);

}  // namespace kawara::vision
