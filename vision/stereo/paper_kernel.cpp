#include "vision/stereo/paper_kernel.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

// Highway compiles this file once for each SIMD target; the table of targets is at the bottom.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/stereo/paper_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef KAWARA_VISION_STEREO_PAPER_TAPS
#define KAWARA_VISION_STEREO_PAPER_TAPS
namespace kawara::vision::paper {

struct alignas(64) Taps {
  float along[kTaps] = {};
  float across[kTaps] = {};
  /// Square roots of the weights, in parts of 32768 / 8, in the first of a tap's four lanes.
  std::int16_t root_weight[4 * kTaps] = {};
  double total = 0.0;
  double total_squared = 0.0;
};

inline const Taps& TheTaps() {
  static const Taps taps = [] {
    struct Tap {
      int along, across, group;
      double weight;
    };
    std::array<Tap, kTaps> all{};  // the last ones stay at the centre, without weight
    std::size_t count = 0;
    for (int i = -kHalfWindow; i <= kHalfWindow; ++i) {
      for (int j = -kHalfWindow; j <= kHalfWindow; ++j) {
        // First the lattice of every other tap about the centre, then those between.
        const bool odd_i = i % 2 != 0, odd_j = j % 2 != 0;
        const bool inner = std::abs(i) <= 3 && std::abs(j) <= 3;
        const int group = inner ? (odd_i == odd_j ? (odd_i ? 0 : 1) : 2) : 3;
        all[count++] = {i, j, group, std::exp(-0.5 * (i * i + j * j) / (kWindowSd * kWindowSd))};
      }
    }
    std::stable_sort(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count),
                     [](const Tap& a, const Tap& b) {
                       return a.group != b.group ? a.group < b.group : a.weight > b.weight;
                     });
    Taps made;
    for (std::size_t k = 0; k < kTaps; ++k) {
      made.along[k] = static_cast<float>(all[k].along);
      made.across[k] = static_cast<float>(all[k].across);
      made.root_weight[4 * k] =
          static_cast<std::int16_t>(std::lround(32768.0 / 8.0 * std::sqrt(all[k].weight)));
      made.total += all[k].weight;
      made.total_squared += all[k].weight * all[k].weight;
    }
    return made;
  }();
  return taps;
}

// The words of a place's whole pixel and the place's distance from it.
struct Origin {
  const std::uint64_t* word;
  float u, v;
};

inline Origin OriginOf(const SquaredPicture& picture, const WindowPlace& place) {
  const int column = static_cast<int>(place.u_px), row = static_cast<int>(place.v_px);
  return {picture.words + 2 * (static_cast<std::ptrdiff_t>(row) * picture.stride + column),
          place.u_px - static_cast<float>(column), place.v_px - static_cast<float>(row)};
}

// Places of taps are in fixed point, 65536 a pixel. Cut off after 1/128 px they are rounded.
constexpr float kFixed = 65536.0F;
constexpr float kHalfFraction = 256.0F;

}  // namespace kawara::vision::paper
#endif

HWY_BEFORE_NAMESPACE();
namespace kawara::vision::paper {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 16>;
using I = hn::Rebind<std::int32_t, F>;
#if HWY_TARGET == HWY_SCALAR

void SampleTap(const Taps& taps, const Origin& origin, int stride, const WindowPlace& place,
               std::size_t tap, std::int16_t level[4]) {
  const auto fixed = [&](float centre, float by_along, float by_across) {
    return static_cast<std::int32_t>(
        taps.along[tap] * (kFixed * by_along) +
        (taps.across[tap] * (kFixed * by_across) + (kFixed * centre + kHalfFraction)));
  };
  const std::int32_t u = fixed(origin.u, place.along_u, place.across_u);
  const std::int32_t v = fixed(origin.v, place.along_v, place.across_v);
  const std::uint64_t* const word =
      origin.word + 2 * (static_cast<std::ptrdiff_t>(v >> 16) * stride + (u >> 16));
  const int right = u >> 9 & 127, down = v >> 9 & 127;
  for (int channel = 0; channel < 4; ++channel) {
    const auto blend = [&](std::uint64_t pair) {
      const int a = static_cast<int>(pair >> (16 * channel) & 0xFFU);
      const int b = static_cast<int>(pair >> (16 * channel + 8) & 0xFFU);
      return 128 * a + (b - a) * right;
    };
    const int upper = blend(word[0]), lower = blend(word[1]);
    level[channel] =
        static_cast<std::int16_t>(upper + (((lower - upper) * (256 * down) + 16384) >> 15));
  }
}

void SampleWindow(const SquaredPicture& picture, const WindowPlace& place, WindowLevels& window) {
  const Origin origin = OriginOf(picture, place);
  for (std::size_t tap = 0; tap < kTaps; ++tap)
    SampleTap(TheTaps(), origin, picture.stride, place, tap, window.level + 4 * tap);
}

std::int64_t GroupCost(const Taps& taps, const std::int16_t* root_weight,
                       const WindowLevels& window, const SquaredPicture& picture,
                       const WindowPlace& place, std::size_t group) {
  const Origin origin = OriginOf(picture, place);
  std::int64_t cost = 0;
  for (std::size_t tap = group; tap < group + kGroup; ++tap) {
    std::int16_t level[4];
    SampleTap(taps, origin, picture.stride, place, tap, level);
    int largest = 0;
    for (std::size_t channel = 0; channel < 4; ++channel)
      largest = std::max(largest, std::abs(level[channel] - window.level[4 * tap + channel]));
    const int rooted = (largest * root_weight[4 * tap] + 16384) >> 15;
    cost += static_cast<std::int64_t>(rooted) * rooted;
  }
  return cost;
}

struct Weights {
  const std::int16_t* root = TheTaps().root_weight;
};
Weights TheWeights() { return {}; }

#else  // vectors of 128 bits or more

using U64 = hn::Repartition<std::uint64_t, I>;
using I64 = hn::RebindToSigned<U64>;
using U16 = hn::Repartition<std::uint16_t, I>;
using I16 = hn::RebindToSigned<U16>;
using U8 = hn::Repartition<std::uint8_t, I>;

// Places of as many taps as a vector of floats has.
struct alignas(64) Grid {
  std::int32_t u[16], v[16];  ///< 1/128 px are the bits 9 to 15
  std::int32_t word[16];
};

// Not inlined: through memory the numbers of the words come cheap, and compilers that see the whole
// take them out of the vector one by one instead.
HWY_NOINLINE void GridOf(const Taps& taps, const Origin& origin, int stride,
                         const WindowPlace& place, std::size_t tap, Grid& grid) {
  const F f;
  const I i32;
  const auto along = hn::Load(f, taps.along + tap), across = hn::Load(f, taps.across + tap);
  const auto fixed = [&](float centre, float by_along, float by_across) {
    return hn::ConvertTo(i32, hn::MulAdd(along, hn::Set(f, kFixed * by_along),
                                         hn::MulAdd(across, hn::Set(f, kFixed * by_across),
                                                    hn::Set(f, kFixed * centre + kHalfFraction))));
  };
  const auto u = fixed(origin.u, place.along_u, place.across_u);
  const auto v = fixed(origin.v, place.along_v, place.across_v);
  hn::Store(u, i32, grid.u);
  hn::Store(v, i32, grid.v);
  const auto row = hn::ShiftRight<16>(v), column = hn::ShiftRight<16>(u);
  hn::Store(hn::ShiftLeft<1>(hn::Add(hn::Mul(row, hn::Set(i32, stride)), column)), i32, grid.word);
}

// Of each four taps of a grid the one number kTap, with its four pixels, in a block of 128 bits.
template <std::size_t kTap>
HWY_INLINE hn::Vec<U16> Pixels(const Origin& origin, const Grid& grid) {
  const U16 u16;
#if HWY_HAVE_SCALABLE
  const U64 u64;
  alignas(64) std::uint64_t words[16];
  for (std::size_t block = 0; block < hn::Lanes(u64) / 2; ++block) {
    words[2 * block] = origin.word[grid.word[4 * block + kTap]];
    words[2 * block + 1] = origin.word[grid.word[4 * block + kTap] + 1];
  }
  return hn::BitCast(u16, hn::Load(u64, words));
#else
  using Block = hn::FixedTag<std::uint64_t, 2>;
  const auto block = [&](std::size_t k) {
    return hn::LoadU(Block(), origin.word + grid.word[4 * k + kTap]);
  };
#if HWY_MAX_BYTES == 16
  return hn::BitCast(u16, block(0));
#else
  const hn::FixedTag<std::uint64_t, 4> two;
#if HWY_MAX_BYTES == 32
  return hn::BitCast(u16, hn::Combine(two, block(1), block(0)));
#else
  return hn::BitCast(u16, hn::Combine(U64(), hn::Combine(two, block(3), block(2)),
                                      hn::Combine(two, block(1), block(0))));
#endif
#endif
#endif
}

// Which bytes of a vector's fractions, four of 32 bits in a block, belong to a tap's channels: to
// all eight of its upper and lower pixels, or to four of the first tap and four of the next.
alignas(16) constexpr std::uint8_t kWhole[4][16] = {
    {0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1},
    {4, 5, 4, 5, 4, 5, 4, 5, 4, 5, 4, 5, 4, 5, 4, 5},
    {8, 9, 8, 9, 8, 9, 8, 9, 8, 9, 8, 9, 8, 9, 8, 9},
    {12, 13, 12, 13, 12, 13, 12, 13, 12, 13, 12, 13, 12, 13, 12, 13}};
alignas(16) constexpr std::uint8_t kHalves[2][16] = {
    {0, 1, 0, 1, 0, 1, 0, 1, 4, 5, 4, 5, 4, 5, 4, 5},
    {8, 9, 8, 9, 8, 9, 8, 9, 12, 13, 12, 13, 12, 13, 12, 13}};

// Levels of half of the grid's taps, number kFirst and the next of each four, in blocks of 128
// bits: four channels of 16 bits each, * 128.
template <std::size_t kFirst>
HWY_INLINE hn::Vec<I16> Sample(const Origin& origin, const Grid& grid) {
  const U64 u64;
  const U16 u16;
  const I16 i16;
  const U8 u8;
  const auto fraction = [&](const std::int32_t* fixed, const std::uint8_t* bytes) {
    const auto places = hn::BitCast(u8, hn::Load(I(), fixed));
    return hn::ShiftRight<9>(
        hn::BitCast(u16, hn::TableLookupBytes(places, hn::LoadDup128(u8, bytes))));
  };
  const auto blend = [&](auto both, const std::uint8_t* bytes) {
    const auto right = hn::BitCast(i16, fraction(grid.u, bytes));
    const auto a = hn::BitCast(i16, hn::And(both, hn::Set(u16, 0xFF)));
    const auto b = hn::BitCast(i16, hn::ShiftRight<8>(both));
    return hn::BitCast(u64, hn::Add(hn::ShiftLeft<7>(a), hn::Mul(hn::Sub(b, a), right)));
  };
  const auto first = blend(Pixels<kFirst>(origin, grid), kWhole[kFirst]);
  const auto second = blend(Pixels<kFirst + 1>(origin, grid), kWhole[kFirst + 1]);
  const auto upper = hn::BitCast(i16, hn::InterleaveLower(u64, first, second));
  const auto lower = hn::BitCast(i16, hn::InterleaveUpper(u64, first, second));
  const auto down = hn::BitCast(i16, hn::ShiftLeft<8>(fraction(grid.v, kHalves[kFirst / 2])));
  return hn::Add(upper, hn::MulFixedPoint15(hn::Sub(lower, upper), down));
}

void SampleWindow(const SquaredPicture& picture, const WindowPlace& place, WindowLevels& window) {
  const Taps& taps = TheTaps();
  const I16 i16;
  const std::size_t lanes = hn::Lanes(F());
  const Origin origin = OriginOf(picture, place);
  for (std::size_t tap = 0; tap < kTaps; tap += lanes) {
    Grid grid;
    GridOf(taps, origin, picture.stride, place, tap, grid);
    hn::Store(Sample<0>(origin, grid), i16, window.level + 4 * tap);
    hn::Store(Sample<2>(origin, grid), i16, window.level + 4 * tap + 2 * lanes);
  }
}

// Weighted squares of eqs. (9) to (11), in the even halves of 64-bit lanes.
HWY_INLINE hn::Vec<I64> Squares(hn::Vec<I16> a, hn::Vec<I16> b, hn::Vec<I16> root_weight) {
  const U64 u64;
  const I i32;
  const I16 i16;
  const auto apart = hn::Abs(hn::Sub(a, b));  // eq. (9)
  const auto pairs = hn::Max(apart, hn::BitCast(i16, hn::ShiftRight<16>(hn::BitCast(u64, apart))));
  const auto largest =
      hn::Max(pairs, hn::BitCast(i16, hn::ShiftRight<32>(hn::BitCast(u64, pairs))));  // eq. (10)
  const auto rooted = hn::BitCast(i32, hn::MulFixedPoint15(largest, root_weight));
  return hn::MulEven(rooted, rooted);
}

HWY_INLINE std::int64_t GroupCost(const Taps& taps, const std::int16_t* root_weight,
                                  const WindowLevels& window, const SquaredPicture& picture,
                                  const WindowPlace& place, std::size_t group) {
  const I64 i64;
  const I16 i16;
  const std::size_t lanes = hn::Lanes(F());
  const Origin origin = OriginOf(picture, place);
  auto sum = hn::Zero(i64);
  for (std::size_t tap = group; tap < group + kGroup; tap += lanes) {
    Grid grid;
    GridOf(taps, origin, picture.stride, place, tap, grid);
    const auto squares = [&](auto sampled, std::size_t at) {
      return Squares(hn::Load(i16, window.level + at), sampled, hn::Load(i16, root_weight + at));
    };
    sum = hn::Add(sum, squares(Sample<0>(origin, grid), 4 * tap));
    sum = hn::Add(sum, squares(Sample<2>(origin, grid), 4 * tap + 2 * lanes));
  }
  return hn::GetLane(hn::SumOfLanes(i64, sum));
}

// The weights in the order in which Sample() brings the taps: of each four the first two, then the
// others.
struct alignas(64) OrderedWeights {
  std::int16_t root[4 * kTaps];
};

const OrderedWeights& TheWeights() {
  static const OrderedWeights weights = [] {
    OrderedWeights made{};
    const Taps& taps = TheTaps();
    const std::size_t lanes = hn::Lanes(F());
    std::size_t to = 0;
    for (std::size_t from = 0; from < kTaps; from += lanes) {
      for (std::size_t half = 0; half < 4; half += 2) {
        for (std::size_t block = 0; block < lanes; block += 4) {
          made.root[4 * to++] = taps.root_weight[4 * (from + block + half)];
          made.root[4 * to++] = taps.root_weight[4 * (from + block + half + 1)];
        }
      }
    }
    return made;
  }();
  return weights;
}

#endif  // HWY_TARGET == HWY_SCALAR

std::int64_t Cost(const WindowLevels& window, const SquaredPicture& picture,
                  const WindowPlace& place) {
  std::int64_t cost = 0;
  for (std::size_t group = 0; group < kTaps; group += kGroup)
    cost += GroupCost(TheTaps(), TheWeights().root, window, picture, place, group);
  return cost;
}

Found Search(const WindowLevels& window, const SquaredPicture& picture, const WindowPlace* places,
             std::size_t count, std::int64_t* first_groups) {
  const Taps& taps = TheTaps();
  const std::int16_t* const root_weight = TheWeights().root;
  // Without a branch from one place to the next, which keeps the processor busy; and most places
  // are out with their first group once the most promising one is known.
  for (std::size_t i = 0; i < count; ++i)
    first_groups[i] = GroupCost(taps, root_weight, window, picture, places[i], 0);
  const auto promising =
      static_cast<std::size_t>(std::min_element(first_groups, first_groups + count) - first_groups);
  Found best{promising, HWY_NAMESPACE::Cost(window, picture, places[promising])};
  for (std::size_t i = 0; i < count; ++i) {
    std::int64_t cost = first_groups[i];
    if (cost > best.cost || i == promising) continue;
    for (std::size_t group = kGroup; group < kTaps && cost <= best.cost; group += kGroup)
      cost += GroupCost(taps, root_weight, window, picture, places[i], group);
    if (cost < best.cost || (cost == best.cost && i < best.place)) best = {i, cost};
  }
  return best;
}

}  // namespace HWY_NAMESPACE
}  // namespace kawara::vision::paper
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kawara::vision::paper {

HWY_EXPORT(SampleWindow);
HWY_EXPORT(Cost);
HWY_EXPORT(Search);

double TotalWeight() { return TheTaps().total; }
double TotalSquaredWeight() { return TheTaps().total_squared; }

void SampleWindow(const SquaredPicture& picture, const WindowPlace& place, WindowLevels& window) {
  HWY_DYNAMIC_DISPATCH(SampleWindow)(picture, place, window);
}

std::int64_t Cost(const WindowLevels& window, const SquaredPicture& picture,
                  const WindowPlace& place) {
  return HWY_DYNAMIC_DISPATCH(Cost)(window, picture, place);
}

Found Search(const WindowLevels& window, const SquaredPicture& picture, const WindowPlace* places,
             std::size_t count, std::int64_t* first_groups) {
  return HWY_DYNAMIC_DISPATCH(Search)(window, picture, places, count, first_groups);
}

}  // namespace kawara::vision::paper
#endif  // HWY_ONCE
