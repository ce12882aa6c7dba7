#pragma once
#include <cstddef>
#include <cstdint>

/// What the paper's method makes of a picture's rows, compiled for every SIMD target (Highway).
namespace kawara::vision::paper {

/// A picture for bilinear taps: two words a pixel, of which the first has the pixel's red, green,
/// blue and seen mark in its bytes 0, 2, 4, 6 and those of the pixel to the right in its bytes 1,
/// 3, 5, 7; the second the same of the row below. One load a tap: gathers are slow on many
/// processors.
struct SquaredPicture {
  const std::uint64_t* words = nullptr;
  int stride = 0;  ///< pixels from a row to the next; not a power of two, for the cache's sake
};
/// A row of it from one packed by MaskedRays::Pack and the one below it. The last pixel has a right
/// neighbour of zeros. words [2 * width].
void SquareRow(const std::uint32_t* row, const std::uint32_t* below, std::size_t width,
               std::uint64_t* words);

/// |gx| + |gy| by Sobel's masks in the channel where it is largest [levels]; columns 0 and width -
/// 1 are not written. Rows as of MaskedRays::Pack.
void SobelRow(const std::uint32_t* above, const std::uint32_t* row, const std::uint32_t* below,
              std::size_t width, std::uint16_t* magnitude);

}  // namespace kawara::vision::paper
