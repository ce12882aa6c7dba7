#include "vision/yuv420.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "core/check.hpp"

static_assert(std::endian::native == std::endian::little, "eight samples are summed as one word");

namespace kawara::vision {
namespace {

constexpr int Half(int px) { return (px + 1) / 2; }
constexpr int WholeBlocks(int px) { return (px + 7) / 8 * 8; }

// A block of luma and chroma together is 16 x 16 px, and the decoder writes whole ones.
std::size_t PlaneBytes(int width_px, int height_px) {
  return PlaneStrideBytes(width_px) * ((static_cast<std::size_t>(height_px) + 15) / 16 * 16);
}

void FillPlaneMargin(const PlaneView& plane) {
  const int wide = WholeBlocks(plane.width_px), high = WholeBlocks(plane.height_px);
  if (wide > plane.width_px) {
    for (int v = 0; v < plane.height_px; ++v) {
      std::uint8_t* const end = plane.row(v) + plane.width_px;
      std::memset(end, end[-1], static_cast<std::size_t>(wide - plane.width_px));
    }
  }
  for (int v = plane.height_px; v < high; ++v) {
    std::memcpy(plane.row(v), plane.row(plane.height_px - 1), static_cast<std::size_t>(wide));
  }
}

// Sums of kFactor x kFactor samples, eight columns at a time: neighbours are added within one
// 64-bit word, in lanes of 16, 32 and 64 bits as kFactor grows. The largest lane holds 8 * 510.
template <int kFactor>
void ReducePlane(const ConstPlaneView& source, const PlaneView& target) {
  constexpr std::uint64_t kEvenBytes = 0x00FF00FF00FF00FFU;
  constexpr std::uint64_t kEvenPairs = 0x0000FFFF0000FFFFU;
  constexpr int kOut = 8 / kFactor;     // results of eight columns
  constexpr int kLaneBits = 64 / kOut;  // where each lies in the word
  constexpr int kCount = kFactor * kFactor;
  for (int v = 0; v < target.height_px; ++v) {
    const std::uint8_t* from = source.row(v * kFactor);
    std::uint8_t* to = target.row(v);
    for (int u = 0; u < target.width_px; u += kOut, from += 8, to += kOut) {
      std::uint64_t sum = 0;
      for (std::size_t k = 0; k < kFactor; ++k) {
        std::uint64_t eight;
        std::memcpy(&eight, from + source.stride_bytes() * k, sizeof eight);
        sum += (eight & kEvenBytes) + ((eight >> 8) & kEvenBytes);
      }
      if constexpr (kFactor >= 4) sum = (sum & kEvenPairs) + ((sum >> 16) & kEvenPairs);
      if constexpr (kFactor == 8) sum = (sum & 0xFFFFFFFFU) + (sum >> 32);
      for (int i = 0; i < kOut; ++i) {  // past the width: into the margin
        const auto lane = static_cast<std::uint32_t>(sum >> (kLaneBits % 64 * i)) & 0xFFFFU;
        to[i] = static_cast<std::uint8_t>((lane + kCount / 2) / kCount);
      }
    }
  }
}

void ReducePlane(const ConstPlaneView& source, int factor, const PlaneView& target) {
  CORE_CHECK(target.width_px == (source.width_px + factor - 1) / factor);
  CORE_CHECK(target.height_px == (source.height_px + factor - 1) / factor);
  switch (factor) {
    case 2:
      return ReducePlane<2>(source, target);
    case 4:
      return ReducePlane<4>(source, target);
    case 8:
      return ReducePlane<8>(source, target);
    default:
      break;
  }
  CORE_CHECK(factor == 1);
  for (int v = 0; v < target.height_px; ++v) {
    std::memcpy(target.row(v), source.row(v), static_cast<std::size_t>(source.width_px));
  }
}

// libjpeg's coefficients in 1/65536 (those of a row sum to 65536 or 0). `n` pixels summed up in
// each colour: shift by 16 + log2 n.
struct RgbSum {
  std::int32_t r = 0, g = 0, b = 0;
  std::int32_t y() const { return 19595 * r + 38470 * g + 7471 * b; }
  std::int32_t cb() const { return -11059 * r - 21709 * g + 32768 * b; }
  std::int32_t cr() const { return 32768 * r - 27439 * g - 5329 * b; }
};

}  // namespace

Yuv420View Yuv420Buffer::View(int width_px, int height_px) {
  const int half_width_px = Half(width_px), half_height_px = Half(height_px);
  const std::size_t luma = PlaneBytes(width_px, height_px);
  const std::size_t chroma = PlaneBytes(half_width_px, half_height_px);
  if (bytes_.size() < luma + 2 * chroma) bytes_.resize(luma + 2 * chroma);
  return {{bytes_.data(), width_px, height_px},
          {bytes_.data() + luma, half_width_px, half_height_px},
          {bytes_.data() + luma + chroma, half_width_px, half_height_px}};
}

void FillMargin(const Yuv420View& picture) {
  FillPlaneMargin(picture.y);
  FillPlaneMargin(picture.cb);
  FillPlaneMargin(picture.cr);
}

void Yuv420FromRgb(const ConstImageView& rgb, const Yuv420View& yuv) {
  CORE_CHECK(rgb.width_px == yuv.width_px() && rgb.height_px == yuv.height_px());
  constexpr std::int32_t kHalf = 1 << 15;
  constexpr std::int32_t kChromaOffset = (128 << 18) + (1 << 17) - 1;  // of four pixels
  for (int v = 0; v < rgb.height_px; v += 2) {
    const int lower_v = std::min(v + 1, rgb.height_px - 1);
    const std::uint8_t* const rows[2] = {rgb.row(v), rgb.row(lower_v)};
    std::uint8_t* const luma[2] = {yuv.y.row(v), yuv.y.row(lower_v)};
    std::uint8_t* const cb = yuv.cb.row(v / 2);
    std::uint8_t* const cr = yuv.cr.row(v / 2);
    for (int u = 0; u < rgb.width_px; u += 2) {
      const int columns[2] = {u, std::min(u + 1, rgb.width_px - 1)};
      RgbSum four;
      for (int row = 0; row < 2; ++row) {
        for (const int column : columns) {
          const std::uint8_t* const p = rows[row] + std::ptrdiff_t{column} * kRgbBytes;
          const RgbSum one{p[0], p[1], p[2]};
          luma[row][column] = static_cast<std::uint8_t>((one.y() + kHalf) >> 16);
          four.r += one.r, four.g += one.g, four.b += one.b;
        }
      }
      cb[u / 2] = static_cast<std::uint8_t>((four.cb() + kChromaOffset) >> 18);
      cr[u / 2] = static_cast<std::uint8_t>((four.cr() + kChromaOffset) >> 18);
    }
  }
  FillMargin(yuv);
}

void ReduceYuv420(const ConstYuv420View& source, int factor, const Yuv420View& target) {
  ReducePlane(source.y, factor, target.y);
  ReducePlane(source.cb, factor, target.cb);
  ReducePlane(source.cr, factor, target.cr);
  FillMargin(target);
}

}  // namespace kawara::vision
