#include "vision/stereo/refine_kernel.hpp"

#include <cmath>

// Highway compiles this file once for each SIMD target; the table of targets is at the bottom.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/stereo/refine_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kawara::vision::refine {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 16>;
using I = hn::Rebind<std::int32_t, F>;
using U = hn::Rebind<std::uint32_t, F>;

template <int kShift, class V>
HWY_INLINE auto Channel(V packed) {
  const F f;
  const U u32;
  return hn::ConvertTo(
      f, hn::BitCast(I(), hn::And(hn::ShiftRight<kShift>(packed), hn::Set(u32, 0xFFU))));
}

void Residuals(const ResidualRow& row, const Evidence& evidence) {
  const F f;
  const I i32;
  const U u32;
  const auto load = [&](const std::uint32_t* from, std::size_t x) {
    return hn::LoadU(u32, from + x);
  };
  const auto* b = reinterpret_cast<const std::int32_t*>(row.b);
  const auto half = hn::Set(f, 0.5F);
  // Of A's own neighbours the first and the last column have none.
  const auto last = hn::Set(f, static_cast<float>(row.width) - 3.0F);
  const auto columns = hn::Set(f, static_cast<float>(row.width) - 1.0F);
  for (std::size_t x = 0; x < row.width; x += hn::Lanes(f)) {
    const auto disparity = hn::LoadU(f, row.disparity + x);
    const auto column = hn::Iota(f, static_cast<float>(x));
    const auto target = hn::Add(column, disparity);
    auto inside = hn::And(hn::And(hn::Ge(disparity, hn::Zero(f)), hn::Lt(target, last)),
                          hn::And(hn::Ge(column, hn::Set(f, 1.0F)), hn::Lt(column, columns)));
    inside = hn::And(inside, hn::Ge(target, hn::Set(f, 1.0F)));
    if (hn::AllFalse(f, inside)) {
      hn::StoreU(hn::Zero(f), f, evidence.slope_error + x);
      hn::StoreU(hn::Zero(f), f, evidence.slope_square + x);
      hn::StoreU(hn::Zero(f), f, evidence.error_square + x);
      hn::StoreU(hn::Zero(f), f, evidence.slope_cross + x);
      continue;
    }
    const auto safe = hn::IfThenElse(inside, target, hn::Set(f, 1.0F));
    const auto whole = hn::ConvertTo(i32, safe);
    const auto t = hn::Sub(safe, hn::ConvertTo(f, whole));
    const auto gather = [&](std::ptrdiff_t offset) {
      return hn::BitCast(u32, hn::GatherIndex(i32, b + offset, whole));
    };
    const auto b0 = gather(-1), b1 = gather(0), b2 = gather(1), b3 = gather(2);
    const auto centre = load(row.a, x);
    const auto left = load(row.a - 1, x), right = load(row.a + 1, x);
    const auto above = load(row.above, x), below = load(row.below, x);
    const auto all = hn::And(hn::And(hn::And(b0, b1), hn::And(b2, b3)),
                             hn::And(hn::And(centre, hn::And(left, right)), hn::And(above, below)));
    const auto seen = hn::And(
        inside, hn::MaskFromVec(hn::BitCast(f, hn::BroadcastSignBit(hn::BitCast(i32, all)))));
    // Catmull-Rom weights and their derivatives.
    const auto m = [&](float c, auto v) { return hn::Mul(hn::Set(f, c), v); };
    const auto t2 = hn::Mul(t, t), t3 = hn::Mul(t2, t);
    const auto w0 = hn::Sub(t2, hn::Mul(half, hn::Add(t, t3)));
    const auto w1 = hn::Add(hn::Sub(m(1.5F, t3), m(2.5F, t2)), hn::Set(f, 1.0F));
    const auto w2 = hn::Sub(hn::Add(m(2.0F, t2), m(0.5F, t)), m(1.5F, t3));
    const auto w3 = hn::Mul(half, hn::Sub(t3, t2));
    const auto s0 = hn::Sub(hn::Sub(m(2.0F, t), half), m(1.5F, t2));
    const auto s1 = hn::Sub(m(4.5F, t2), m(5.0F, t));
    const auto s2 = hn::Add(hn::Sub(m(4.0F, t), m(4.5F, t2)), half);
    const auto s3 = hn::Sub(m(1.5F, t2), t);
    auto slope_error = hn::Zero(f), slope_square = hn::Zero(f), error_square = hn::Zero(f);
    auto slope_cross = hn::Zero(f);
    const auto add = [&](auto pa, auto pl, auto pr, auto pu, auto pd, auto p0, auto p1, auto p2,
                         auto p3, const GainLine* gains) {
      const GainLine& line = gains[x / kGainColumns];
      const auto gain = hn::MulAdd(hn::Set(f, line.rise), column, hn::Set(f, line.base));
      const auto value =
          hn::MulAdd(w0, p0, hn::MulAdd(w1, p1, hn::MulAdd(w2, p2, hn::Mul(w3, p3))));
      const auto rise = hn::MulAdd(s0, p0, hn::MulAdd(s1, p1, hn::MulAdd(s2, p2, hn::Mul(s3, p3))));
      const auto error = hn::NegMulAdd(gain, value, pa);
      // Mean of both pictures' slopes: noise in one alone would pull towards too small a step.
      const auto slope = hn::Mul(half, hn::MulAdd(half, hn::Sub(pr, pl), hn::Mul(gain, rise)));
      slope_error = hn::MulAdd(slope, error, slope_error);
      slope_square = hn::MulAdd(slope, slope, slope_square);
      error_square = hn::MulAdd(error, error, error_square);
      slope_cross = hn::MulAdd(slope, hn::Mul(half, hn::Sub(pd, pu)), slope_cross);
    };
    add(Channel<0>(centre), Channel<0>(left), Channel<0>(right), Channel<0>(above),
        Channel<0>(below), Channel<0>(b0), Channel<0>(b1), Channel<0>(b2), Channel<0>(b3),
        row.gain[0]);
    add(Channel<8>(centre), Channel<8>(left), Channel<8>(right), Channel<8>(above),
        Channel<8>(below), Channel<8>(b0), Channel<8>(b1), Channel<8>(b2), Channel<8>(b3),
        row.gain[1]);
    add(Channel<16>(centre), Channel<16>(left), Channel<16>(right), Channel<16>(above),
        Channel<16>(below), Channel<16>(b0), Channel<16>(b1), Channel<16>(b2), Channel<16>(b3),
        row.gain[2]);
    error_square = hn::Mul(error_square, hn::Set(f, 1.0F / 3.0F));
    const auto one = hn::Set(f, 1.0F);
    const auto weight = hn::Div(one, hn::MulAdd(hn::Set(f, row.softness), error_square, one));
    hn::StoreU(hn::IfThenElseZero(seen, hn::Mul(weight, slope_error)), f, evidence.slope_error + x);
    hn::StoreU(hn::IfThenElseZero(seen, hn::Mul(weight, slope_square)), f,
               evidence.slope_square + x);
    hn::StoreU(hn::IfThenElseZero(seen, hn::Mul(weight, error_square)), f,
               evidence.error_square + x);
    hn::StoreU(hn::IfThenElseZero(seen, hn::Mul(weight, slope_cross)), f, evidence.slope_cross + x);
  }
}

struct Taps {
  float weight[2 * kRadius + 1];
  float edge[2 * kRadius + 1];
  float inverse_total;
};

Taps MakeTaps() {
  Taps taps{};
  for (int k = -kRadius; k <= kRadius; ++k) {
    const auto distance = static_cast<float>(k < 0 ? -k : k);
    taps.weight[k + kRadius] = std::exp(-0.5F * distance * distance / (kWindowSd * kWindowSd));
    taps.edge[k + kRadius] = kEdge * (1.0F + kEdgeGrowth * distance);
  }
  float total = 0.0F;
  for (const float weight : taps.weight) total += weight;
  taps.inverse_total = 1.0F / total;
  return taps;
}

// kAlong: the neighbours are in the row itself, else the same columns of the rows about it.
template <bool kAlong>
HWY_INLINE void Smooth(const SmoothRow* const* rows, std::size_t width, const SmoothRow& out) {
  static const Taps taps = MakeTaps();
  const F f;
  const float* guide = rows[kAlong ? 0 : kRadius]->disparity;
  for (std::size_t x = 0; x < width; x += hn::Lanes(f)) {
    const auto own = hn::LoadU(f, guide + x);
    const auto known = hn::Ge(own, hn::Zero(f));
    auto total = hn::Zero(f), disparity = hn::Zero(f), support = hn::Zero(f);
    auto slope_error = hn::Zero(f), slope_square = hn::Zero(f), error_square = hn::Zero(f);
    auto slope_cross = hn::Zero(f);
    if (!hn::AllFalse(f, known)) {
      for (int k = 0; k < 2 * kRadius + 1; ++k) {
        const SmoothRow* row = rows[kAlong ? 0 : k];
        if (!kAlong && row == nullptr) continue;
        const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(x) + (kAlong ? k - kRadius : 0);
        const auto apart = hn::Sub(hn::LoadU(f, row->disparity + at), own);
        const auto same = hn::Lt(hn::Abs(apart), hn::Set(f, taps.edge[k]));
        const auto weight = hn::IfThenElseZero(same, hn::Set(f, taps.weight[k]));
        total = hn::Add(total, weight);
        if constexpr (!kAlong)
          support = hn::MulAdd(weight, hn::LoadU(f, row->support + at), support);
        disparity = hn::MulAdd(weight, apart, disparity);
        slope_error = hn::MulAdd(weight, hn::LoadU(f, row->evidence.slope_error + at), slope_error);
        slope_square =
            hn::MulAdd(weight, hn::LoadU(f, row->evidence.slope_square + at), slope_square);
        error_square =
            hn::MulAdd(weight, hn::LoadU(f, row->evidence.error_square + at), error_square);
        slope_cross = hn::MulAdd(weight, hn::LoadU(f, row->evidence.slope_cross + at), slope_cross);
      }
    }
    const auto scale = hn::Div(hn::Set(f, 1.0F), hn::Max(total, hn::Set(f, 1e-6F)));
    hn::StoreU(hn::IfThenElse(known, hn::MulAdd(disparity, scale, own), hn::Set(f, kNone)), f,
               out.disparity + x);
    hn::StoreU(hn::Mul(slope_error, scale), f, out.evidence.slope_error + x);
    hn::StoreU(hn::Mul(slope_square, scale), f, out.evidence.slope_square + x);
    hn::StoreU(hn::Mul(error_square, scale), f, out.evidence.error_square + x);
    hn::StoreU(hn::Mul(slope_cross, scale), f, out.evidence.slope_cross + x);
    hn::StoreU(hn::Mul(kAlong ? total : support, hn::Set(f, taps.inverse_total)), f,
               out.support + x);
  }
}

void SmoothAlong(const SmoothRow& in, std::size_t width, const SmoothRow& out) {
  const SmoothRow* const row = &in;
  Smooth<true>(&row, width, out);
}

void SmoothAcross(const SmoothRow* const rows[2 * kRadius + 1], std::size_t width,
                  const SmoothRow& out) {
  Smooth<false>(rows, width, out);
}

// What of the squared slopes is the scene's: the noise's own are taken off, but never all.
template <class V>
HWY_INLINE V SceneSlopes(V slope_square, V error_square) {
  const F f;
  return hn::Max(hn::NegMulAdd(hn::Set(f, kNoiseSlopes), error_square, slope_square),
                 hn::Mul(hn::Set(f, kLeastScene), slope_square));
}

void Advance(const SmoothRow& smoothed, std::size_t width, float* disparity) {
  const F f;
  const auto zero = hn::Zero(f), none = hn::Set(f, kNone), largest = hn::Set(f, kLargestStep);
  for (std::size_t x = 0; x < width; x += hn::Lanes(f)) {
    const auto now = hn::LoadU(f, smoothed.disparity + x);
    const auto square = hn::LoadU(f, smoothed.evidence.slope_square + x);
    const auto plain = hn::Set(f, kPlain);
    const auto ratio =
        hn::Div(hn::LoadU(f, smoothed.evidence.slope_error + x), hn::Max(square, plain));
    const auto step = hn::IfThenElseZero(hn::Gt(square, plain),
                                         hn::Max(hn::Neg(largest), hn::Min(ratio, largest)));
    hn::StoreU(hn::IfThenElse(hn::Ge(now, zero), hn::Max(zero, hn::Add(now, step)), none), f,
               disparity + x);
  }
}

void Deviations(const SmoothRow& smoothed, std::size_t width, float* sd) {
  const F f;
  const Evidence& evidence = smoothed.evidence;
  for (std::size_t x = 0; x < width; x += hn::Lanes(f)) {
    const auto residual =
        hn::Max(hn::LoadU(f, evidence.error_square + x), hn::Set(f, kLeastResidual));
    const auto scene = SceneSlopes(hn::LoadU(f, evidence.slope_square + x),
                                   hn::LoadU(f, evidence.error_square + x));
    const auto slope = hn::Max(scene, hn::Set(f, 1e-3F));
    const auto noise = hn::MulAdd(hn::Set(f, kWindowVariance), residual, hn::Set(f, kPattern));
    const auto slant =
        hn::Mul(hn::Set(f, kRowSd), hn::Div(hn::LoadU(f, evidence.slope_cross + x), slope));
    const auto variance =
        hn::MulAdd(slant, slant, hn::Add(hn::Div(noise, slope), hn::Set(f, kFloorSd * kFloorSd)));
    // At an edge there are fewer neighbours, and those are not quite of the surface either.
    const auto support = hn::Max(hn::LoadU(f, smoothed.support + x), hn::Set(f, 0.05F));
    hn::StoreU(hn::Div(hn::Sqrt(variance), support), f, sd + x);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kawara::vision::refine
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kawara::vision::refine {

HWY_EXPORT(Residuals);
HWY_EXPORT(SmoothAlong);
HWY_EXPORT(SmoothAcross);
HWY_EXPORT(Advance);
HWY_EXPORT(Deviations);

void Residuals(const ResidualRow& row, const Evidence& evidence) {
  HWY_DYNAMIC_DISPATCH(Residuals)(row, evidence);
}

void SmoothAlong(const SmoothRow& in, std::size_t width, const SmoothRow& out) {
  HWY_DYNAMIC_DISPATCH(SmoothAlong)(in, width, out);
}

void SmoothAcross(const SmoothRow* const rows[2 * kRadius + 1], std::size_t width,
                  const SmoothRow& out) {
  HWY_DYNAMIC_DISPATCH(SmoothAcross)(rows, width, out);
}

void Advance(const SmoothRow& smoothed, std::size_t width, float* disparity) {
  HWY_DYNAMIC_DISPATCH(Advance)(smoothed, width, disparity);
}

void Deviations(const SmoothRow& smoothed, std::size_t width, float* sd) {
  HWY_DYNAMIC_DISPATCH(Deviations)(smoothed, width, sd);
}

}  // namespace kawara::vision::refine
#endif  // HWY_ONCE
