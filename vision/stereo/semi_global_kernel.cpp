#include "vision/stereo/semi_global_kernel.hpp"

#include <algorithm>
#include <cstring>

// Highway compiles this file once for each SIMD target; the table of targets is at the bottom.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/stereo/semi_global_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kawara::vision::semi_global {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// At most kLane lanes, so that any multiple of kLane is whole vectors on every target.
using D16 = hn::CappedTag<std::uint16_t, kLane>;
using D8 = hn::CappedTag<std::uint8_t, kLane>;
using Half8 = hn::Rebind<std::uint8_t, D16>;

void Differences(const std::uint8_t* a, const std::uint8_t* a_seen, const std::uint8_t* b,
                 const std::uint8_t* b_seen, std::size_t width, std::size_t disparities,
                 std::uint8_t* differences) {
  const D8 d8;
  const auto cap = hn::Set(d8, kCap), unseen = hn::Set(d8, kUnseen);
  for (std::size_t x = 0; x < width; ++x) {
    const auto level = hn::Set(d8, a[x]), both = hn::Set(d8, a_seen[x]);
    for (std::size_t d = 0; d < disparities; d += hn::Lanes(d8)) {
      const auto other = hn::LoadU(d8, b + x + d);
      const auto mask = hn::And(both, hn::LoadU(d8, b_seen + x + d));
      const auto apart =
          hn::Min(hn::Or(hn::SaturatedSub(level, other), hn::SaturatedSub(other, level)), cap);
      hn::StoreU(hn::Or(hn::And(mask, apart), hn::AndNot(mask, unseen)), d8,
                 differences + x * disparities + d);
    }
  }
}

void SlideRows(const std::uint8_t* added, const std::uint8_t* removed, std::size_t count,
               std::uint16_t* sum) {
  const D16 d16;
  const Half8 d8;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d16)) {
    const auto more = hn::PromoteTo(d16, hn::LoadU(d8, added + i));
    const auto less = hn::PromoteTo(d16, hn::LoadU(d8, removed + i));
    hn::StoreU(hn::Sub(hn::Add(hn::LoadU(d16, sum + i), more), less), d16, sum + i);
  }
}

void WindowCosts(const std::uint16_t* sum, std::size_t width, std::size_t disparities,
                 std::uint8_t* cost) {
  const D16 d16;
  const Half8 d8;
  const auto column = [&](std::ptrdiff_t x) {
    const auto last = static_cast<std::ptrdiff_t>(width) - 1;
    return sum + static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(x, 0, last)) * disparities;
  };
  for (std::size_t d = 0; d < disparities; d += hn::Lanes(d16)) {
    auto window = hn::Zero(d16);
    for (int k = -kWindow; k < kWindow; ++k)
      window = hn::Add(window, hn::LoadU(d16, column(k) + d));
    for (std::size_t x = 0; x < width; ++x) {
      const auto at = static_cast<std::ptrdiff_t>(x);
      window = hn::Add(window, hn::LoadU(d16, column(at + kWindow) + d));
      hn::StoreU(
          hn::DemoteTo(d8, hn::BitCast(hn::RebindToSigned<D16>(), hn::ShiftRight<4>(window))), d8,
          cost + x * disparities + d);
      window = hn::Sub(window, hn::LoadU(d16, column(at - kWindow) + d));
    }
  }
}

// Source: H. Hirschmueller, Stereo processing by semiglobal matching and mutual information, 2008,
// eq. (13).
template <class V16>
HWY_INLINE V16 Step(V16 cost, const std::uint16_t* before, V16 jump, V16 step, V16 base) {
  const D16 d16;
  const auto stay = hn::LoadU(d16, before);
  const auto beside = hn::Min(hn::LoadU(d16, before - 1), hn::LoadU(d16, before + 1));
  const auto cheapest = hn::Min(hn::Min(stay, hn::Add(beside, step)), jump);
  return hn::Add(cost, hn::Sub(cheapest, base));
}

struct Before {
  const std::uint16_t* cost;
  std::uint16_t least;
};

// One pixel of one path: the costs into `path`, their least returned, the sum onto `total`.
template <bool kFirst>
HWY_INLINE std::uint16_t PathPixel(const std::uint8_t* cost, const Before& before,
                                   std::size_t disparities, std::uint16_t* path,
                                   std::uint16_t* total) {
  const D16 d16;
  const Half8 d8;
  const auto base = hn::Set(d16, before.least);
  const auto jump = hn::Set(d16, static_cast<std::uint16_t>(before.least + kJumpCost));
  const auto step = hn::Set(d16, kStepCost);
  auto least = hn::Set(d16, std::uint16_t{0xFFFF});
  for (std::size_t d = 0; d < disparities; d += hn::Lanes(d16)) {
    const auto here = hn::PromoteTo(d16, hn::LoadU(d8, cost + d));
    const auto value = Step(here, before.cost + d, jump, step, base);
    least = hn::Min(least, value);
    hn::StoreU(value, d16, path + d);
    if constexpr (kFirst) {
      hn::StoreU(value, d16, total + d);
    } else {
      hn::StoreU(hn::Add(value, hn::LoadU(d16, total + d)), d16, total + d);
    }
  }
  return hn::GetLane(hn::MinOfLanes(d16, least));
}

HWY_INLINE void ClearPixel(std::uint16_t* path, std::size_t disparities) {
  std::memset(path, 0, disparities * sizeof(std::uint16_t));
}

// Neighbours of column x in the row before: left, same, right. Outside the picture nothing was, as
// where nothing is seen: all zeros, which is what column `width` of every row holds.
template <bool kFirstStores>
HWY_INLINE void FromRowBefore(const std::uint8_t* cost, std::size_t x, std::size_t width,
                              std::size_t disparities, const PathRow previous[3],
                              const PathRow current[3], std::uint16_t* total) {
  const std::size_t stride = PathStride(disparities);
  const std::size_t from[3] = {x > 0 ? x - 1 : width, x, x + 1};
  for (std::size_t k = 0; k < 3; ++k) {
    const Before before{previous[k].cost + from[k] * stride + kPathPad, previous[k].least[from[k]]};
    std::uint16_t* path = current[k].cost + x * stride + kPathPad;
    current[k].least[x] = k == 0 && kFirstStores
                              ? PathPixel<true>(cost, before, disparities, path, total)
                              : PathPixel<false>(cost, before, disparities, path, total);
  }
}

HWY_INLINE void ClearColumn(std::size_t x, std::size_t disparities, const PathRow rows[3]) {
  for (std::size_t k = 0; k < 3; ++k) {
    ClearPixel(rows[k].cost + x * PathStride(disparities) + kPathPad, disparities);
    rows[k].least[x] = 0;
  }
}

void PathsDown(const std::uint8_t* cost, const std::uint8_t* seen, std::size_t width,
               std::size_t disparities, const PathRow previous[3], const PathRow current[3],
               const PathRow& along, std::uint16_t* total) {
  const std::size_t stride = PathStride(disparities);
  const auto path = [&](std::size_t x) { return along.cost + x * stride + kPathPad; };
  // Column `width` is the pixel before the first, from either side.
  ClearPixel(path(width), disparities);
  along.least[width] = 0;
  std::size_t before = width;
  for (std::size_t x = 0; x < width; ++x) {
    if (seen[x] == 0) {
      ClearColumn(x, disparities, current);
      ClearPixel(path(x), disparities);
      along.least[x] = 0;
    } else {
      FromRowBefore<true>(cost + x * disparities, x, width, disparities, previous, current,
                          total + x * disparities);
      along.least[x] = PathPixel<false>(cost + x * disparities, {path(before), along.least[before]},
                                        disparities, path(x), total + x * disparities);
    }
    before = x;
  }
  before = width;
  for (std::size_t x = width; x-- > 0;) {
    if (seen[x] == 0) {
      ClearPixel(path(x), disparities);
      along.least[x] = 0;
    } else {
      along.least[x] = PathPixel<false>(cost + x * disparities, {path(before), along.least[before]},
                                        disparities, path(x), total + x * disparities);
    }
    before = x;
  }
}

void PathsUp(const std::uint8_t* cost, const std::uint8_t* seen, std::size_t width,
             std::size_t disparities, const PathRow previous[3], const PathRow current[3],
             std::uint16_t* total) {
  for (std::size_t x = 0; x < width; ++x) {
    if (seen[x] == 0) {
      ClearColumn(x, disparities, current);
    } else {
      FromRowBefore<false>(cost + x * disparities, x, width, disparities, previous, current,
                           total + x * disparities);
    }
  }
}

void FindMinima(const std::uint16_t* total, const std::uint8_t* seen, std::size_t width,
                std::size_t disparities, const RowMinima& minima) {
  const D16 d16;
  const std::size_t lanes = hn::Lanes(d16);
  for (std::size_t x = 0; x < width + disparities; ++x) minima.b_cost[x] = 0xFFFF;
  for (std::size_t x = 0; x < width; ++x) {
    if (seen[x] == 0) continue;
    const std::uint16_t* costs = total + x * disparities;
    auto least = hn::Set(d16, std::uint16_t{0xFFFF});
    for (std::size_t d = 0; d < disparities; d += lanes) {
      const auto here = hn::LoadU(d16, costs + d);
      least = hn::Min(least, here);
      std::uint16_t* b_cost = minima.b_cost + x + d;
      std::uint16_t* b_best = minima.b_best + x + d;
      const auto there = hn::LoadU(d16, b_cost);
      const auto better = hn::Lt(here, there);
      const auto index = hn::Iota(d16, static_cast<std::uint16_t>(d));
      hn::StoreU(hn::Min(here, there), d16, b_cost);
      hn::StoreU(hn::IfThenElse(better, index, hn::LoadU(d16, b_best)), d16, b_best);
    }
    const std::uint16_t best_cost = hn::GetLane(hn::MinOfLanes(d16, least));
    std::size_t best = 0;
    const auto wanted = hn::Set(d16, best_cost);
    for (std::size_t d = 0; d < disparities; d += lanes) {
      const auto found = hn::FindFirstTrue(d16, hn::Eq(hn::LoadU(d16, costs + d), wanted));
      if (found >= 0) {
        best = d + static_cast<std::size_t>(found);
        break;
      }
    }
    auto second = hn::Set(d16, std::uint16_t{0xFFFF});
    const auto centre = hn::Set(d16, static_cast<std::uint16_t>(best + 1));
    for (std::size_t d = 0; d < disparities; d += lanes) {
      // best - 1 <= index <= best + 1 is beside it; in unsigned numbers without a branch.
      const auto index = hn::Iota(d16, static_cast<std::uint16_t>(d));
      const auto behind = hn::Sub(centre, index);
      const auto beside = hn::Lt(behind, hn::Set(d16, std::uint16_t{3}));
      second = hn::Min(second, hn::IfThenElse(beside, second, hn::LoadU(d16, costs + d)));
    }
    minima.best[x] = static_cast<std::uint16_t>(best);
    minima.best_cost[x] = best_cost;
    minima.second_cost[x] = hn::GetLane(hn::MinOfLanes(d16, second));
  }
}

void FindRepeats(const std::uint8_t* cost, const std::uint16_t* best, std::size_t width,
                 std::size_t disparities, std::uint8_t* repeats) {
  const D16 d16;
  const Half8 d8;
  for (std::size_t x = 0; x < width; ++x) {
    const std::uint8_t* costs = cost + x * disparities;
    auto second = hn::Set(d16, std::uint16_t{0xFFFF});
    auto sum = hn::Zero(d16);
    const auto centre = hn::Set(d16, static_cast<std::uint16_t>(best[x] + kBesides));
    for (std::size_t d = 0; d < disparities; d += hn::Lanes(d16)) {
      const auto here = hn::PromoteTo(d16, hn::LoadU(d8, costs + d));
      const auto index = hn::Iota(d16, static_cast<std::uint16_t>(d));
      const auto beside =
          hn::Lt(hn::Sub(centre, index), hn::Set(d16, std::uint16_t{2 * kBesides + 1}));
      second = hn::Min(second, hn::IfThenElse(beside, second, here));
      sum = hn::Add(sum, here);
    }
    const int own = costs[best[x]];
    const int other = hn::GetLane(hn::MinOfLanes(d16, second));
    const int mean = static_cast<int>(hn::GetLane(hn::SumOfLanes(d16, sum)) / disparities);
    const bool has_structure = mean - own > kStructure;
    repeats[x] = has_structure && kRepeatPart * (other - own) < mean - own ? 1 : 0;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kawara::vision::semi_global
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kawara::vision::semi_global {

HWY_EXPORT(Differences);
HWY_EXPORT(SlideRows);
HWY_EXPORT(WindowCosts);
HWY_EXPORT(PathsDown);
HWY_EXPORT(PathsUp);
HWY_EXPORT(FindMinima);
HWY_EXPORT(FindRepeats);

void Differences(const std::uint8_t* a, const std::uint8_t* a_seen, const std::uint8_t* b,
                 const std::uint8_t* b_seen, std::size_t width, std::size_t disparities,
                 std::uint8_t* differences) {
  HWY_DYNAMIC_DISPATCH(Differences)(a, a_seen, b, b_seen, width, disparities, differences);
}

void SlideRows(const std::uint8_t* added, const std::uint8_t* removed, std::size_t count,
               std::uint16_t* sum) {
  HWY_DYNAMIC_DISPATCH(SlideRows)(added, removed, count, sum);
}

void WindowCosts(const std::uint16_t* sum, std::size_t width, std::size_t disparities,
                 std::uint8_t* cost) {
  HWY_DYNAMIC_DISPATCH(WindowCosts)(sum, width, disparities, cost);
}

void PathsDown(const std::uint8_t* cost, const std::uint8_t* seen, std::size_t width,
               std::size_t disparities, const PathRow previous[3], const PathRow current[3],
               const PathRow& along, std::uint16_t* total) {
  HWY_DYNAMIC_DISPATCH(PathsDown)
  (cost, seen, width, disparities, previous, current, along, total);
}

void PathsUp(const std::uint8_t* cost, const std::uint8_t* seen, std::size_t width,
             std::size_t disparities, const PathRow previous[3], const PathRow current[3],
             std::uint16_t* total) {
  HWY_DYNAMIC_DISPATCH(PathsUp)(cost, seen, width, disparities, previous, current, total);
}

void FindMinima(const std::uint16_t* total, const std::uint8_t* seen, std::size_t width,
                std::size_t disparities, const RowMinima& minima) {
  HWY_DYNAMIC_DISPATCH(FindMinima)(total, seen, width, disparities, minima);
}

void FindRepeats(const std::uint8_t* cost, const std::uint16_t* best, std::size_t width,
                 std::size_t disparities, std::uint8_t* repeats) {
  HWY_DYNAMIC_DISPATCH(FindRepeats)(cost, best, width, disparities, repeats);
}

}  // namespace kawara::vision::semi_global
#endif  // HWY_ONCE
