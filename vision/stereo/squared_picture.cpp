#include "vision/stereo/squared_picture.hpp"

#include <algorithm>
#include <cstdlib>

// Highway compiles this file once for each SIMD target; the table of targets is at the bottom.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/stereo/squared_picture.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef KAWARA_VISION_STEREO_SQUARED_PICTURE_PLAIN
#define KAWARA_VISION_STEREO_SQUARED_PICTURE_PLAIN
namespace kawara::vision::paper {

// The plain form of the kernels of the same name: for the ends of rows, and for processors without
// vectors of 128 bits.
inline std::uint64_t PlainPair(std::uint32_t left, std::uint32_t right) {
  std::uint64_t word = 0;
  for (int channel = 0; channel < 4; ++channel) {
    const auto byte = [&](std::uint32_t of) -> std::uint64_t {
      return of >> (8 * channel) & 0xFFU;
    };
    word |= (byte(left) | byte(right) << 8) << (16 * channel);
  }
  return word;
}

inline void PlainSquares(const std::uint32_t* row, const std::uint32_t* below, std::size_t from,
                         std::size_t width, std::uint64_t* words) {
  for (std::size_t x = from; x < width; ++x) {
    words[2 * x] = PlainPair(row[x], x + 1 < width ? row[x + 1] : 0U);
    words[2 * x + 1] = PlainPair(below[x], x + 1 < width ? below[x + 1] : 0U);
  }
}

inline void PlainSobel(const std::uint32_t* above, const std::uint32_t* row,
                       const std::uint32_t* below, std::size_t width, std::uint16_t* magnitude) {
  for (std::size_t x = 1; x + 1 < width; ++x) {
    int best = 0;
    for (int shift = 0; shift < 24; shift += 8) {
      const auto at = [&](const std::uint32_t* from, std::size_t k) {
        return static_cast<int>(from[k] >> shift & 0xFFU);
      };
      const int gx = at(above, x + 1) + 2 * at(row, x + 1) + at(below, x + 1) - at(above, x - 1) -
                     2 * at(row, x - 1) - at(below, x - 1);
      const int gy = at(below, x - 1) + 2 * at(below, x) + at(below, x + 1) - at(above, x - 1) -
                     2 * at(above, x) - at(above, x + 1);
      best = std::max(best, std::abs(gx) + std::abs(gy));
    }
    magnitude[x] = static_cast<std::uint16_t>(best);
  }
}

}  // namespace kawara::vision::paper
#endif

HWY_BEFORE_NAMESPACE();
namespace kawara::vision::paper {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR

void SquareRow(const std::uint32_t* row, const std::uint32_t* below, std::size_t width,
               std::uint64_t* words) {
  PlainSquares(row, below, 0, width, words);
}

void SobelRow(const std::uint32_t* above, const std::uint32_t* row, const std::uint32_t* below,
              std::size_t width, std::uint16_t* magnitude) {
  PlainSobel(above, row, below, width, magnitude);
}

#else  // vectors of 128 bits or more

using I = hn::CappedTag<std::int32_t, 16>;
using U64 = hn::Repartition<std::uint64_t, I>;
using I16 = hn::Repartition<std::int16_t, I>;

void SquareRow(const std::uint32_t* row, const std::uint32_t* below, std::size_t width,
               std::uint64_t* words) {
  const U64 u64;
  const hn::Rebind<std::uint32_t, U64> u32;
  const auto spread = [&](const std::uint32_t* from) {
    auto wide = hn::PromoteTo(u64, hn::LoadU(u32, from));
    wide = hn::And(hn::Or(wide, hn::ShiftLeft<16>(wide)), hn::Set(u64, 0x0000FFFF0000FFFFULL));
    return hn::And(hn::Or(wide, hn::ShiftLeft<8>(wide)), hn::Set(u64, 0x00FF00FF00FF00FFULL));
  };
  const auto pair = [&](const std::uint32_t* from) {
    return hn::Or(spread(from), hn::ShiftLeft<8>(spread(from + 1)));
  };
  std::size_t x = 0;
  for (; x + hn::Lanes(u64) < width; x += hn::Lanes(u64)) {
    hn::StoreInterleaved2(pair(row + x), pair(below + x), u64, words + 2 * x);
  }
  PlainSquares(row, below, x, width, words);
}

void SobelRow(const std::uint32_t* above, const std::uint32_t* row, const std::uint32_t* below,
              std::size_t width, std::uint16_t* magnitude) {
  // Channels 0 and 2 of a pixel in one word, channel 1 (and the seen mark) in another.
  const I i32;
  const I16 i16;
  const hn::RebindToUnsigned<I> u32;
  const auto channels = [&](const std::uint32_t* from) {
    struct {
      hn::Vec<I16> even, odd;
    } both{};
    const auto words = hn::LoadU(u32, from);
    const auto mask = hn::Set(u32, 0x00FF00FFU);
    both.even = hn::BitCast(i16, hn::And(words, mask));
    both.odd = hn::BitCast(i16, hn::And(hn::ShiftRight<8>(words), mask));
    return both;
  };
  const auto strength = [](auto al, auto am, auto ar, auto l, auto r, auto bl, auto bm, auto br) {
    const auto gx =
        hn::Sub(hn::Add(hn::Add(ar, br), hn::Add(r, r)), hn::Add(hn::Add(al, bl), hn::Add(l, l)));
    const auto gy = hn::Sub(hn::Add(hn::Add(bl, br), hn::Add(bm, bm)),
                            hn::Add(hn::Add(al, ar), hn::Add(am, am)));
    return hn::Add(hn::Abs(gx), hn::Abs(gy));
  };
  const std::size_t lanes = hn::Lanes(i32);
  if (width < lanes + 2) return PlainSobel(above, row, below, width, magnitude);
  for (std::size_t x = 1; x + 1 < width;) {
    // The last vector overlaps the one before it, so that no row is read behind its end.
    x = std::min(x, width - 1 - lanes);
    const auto al = channels(above + x - 1), am = channels(above + x), ar = channels(above + x + 1);
    const auto l = channels(row + x - 1), r = channels(row + x + 1);
    const auto bl = channels(below + x - 1), bm = channels(below + x), br = channels(below + x + 1);
    const auto even =
        strength(al.even, am.even, ar.even, l.even, r.even, bl.even, bm.even, br.even);
    // The mark's half word may be anything: the lower one counts.
    const auto odd = strength(al.odd, am.odd, ar.odd, l.odd, r.odd, bl.odd, bm.odd, br.odd);
    const auto low = hn::Set(u32, 0xFFFFU);
    const auto red = hn::BitCast(i32, hn::And(hn::BitCast(u32, even), low));
    const auto blue = hn::BitCast(i32, hn::ShiftRight<16>(hn::BitCast(u32, even)));
    const auto green = hn::BitCast(i32, hn::And(hn::BitCast(u32, odd), low));
    const auto best = hn::Max(hn::Max(red, blue), green);
    const hn::Rebind<std::uint16_t, I> half;
    hn::StoreU(hn::DemoteTo(half, best), half, magnitude + x);
    x += lanes;
  }
}

#endif  // HWY_TARGET == HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace kawara::vision::paper
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kawara::vision::paper {

HWY_EXPORT(SquareRow);
HWY_EXPORT(SobelRow);

void SquareRow(const std::uint32_t* row, const std::uint32_t* below, std::size_t width,
               std::uint64_t* words) {
  HWY_DYNAMIC_DISPATCH(SquareRow)(row, below, width, words);
}

void SobelRow(const std::uint32_t* above, const std::uint32_t* row, const std::uint32_t* below,
              std::size_t width, std::uint16_t* magnitude) {
  HWY_DYNAMIC_DISPATCH(SobelRow)(above, row, below, width, magnitude);
}

}  // namespace kawara::vision::paper
#endif  // HWY_ONCE
