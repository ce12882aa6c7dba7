#include "vision/stereo/range_kernel.hpp"

#include <cstdint>
#include <limits>

// Highway compiles this file once for each SIMD target; the table of targets is at the bottom.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/stereo/range_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After highway.h.
#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace kawara::vision::range {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 16>;
using I = hn::Rebind<std::int32_t, F>;

constexpr float kPi = 3.14159265F;
/// Disparities of one surface differ by less between neighbouring pixels.
constexpr float kSameSurface = 1.0F;

// Angle of (across, along) from the direction of `along`, across >= 0: 0 to pi.
template <class V>
HWY_INLINE V AngleTo(V across, V along) {
  const F f;
  const auto size = hn::Abs(along);
  const auto steep = hn::Gt(across, size);
  const auto least = hn::Set(f, 1e-30F);
  const auto ratio = hn::Div(hn::IfThenElse(steep, size, across),
                             hn::Max(hn::IfThenElse(steep, across, size), least));
  const auto octant = hn::Atan(f, ratio);
  const auto quadrant = hn::IfThenElse(steep, hn::Sub(hn::Set(f, kPi / 2), octant), octant);
  return hn::IfThenElse(hn::Lt(along, hn::Zero(f)), hn::Sub(hn::Set(f, kPi), quadrant), quadrant);
}

void RangesOfRow(const FieldView& field, const float* x, const float* y, const float* z,
                 std::size_t count, float* range_m, float* sd_m) {
  const F f;
  const I i32;
  const auto unknown = hn::Set(f, std::numeric_limits<float>::quiet_NaN());
  const auto* m = field.epipolar_from_camera;
  const auto px_per_rad = hn::Set(f, field.px_per_rad);
  const auto rad_per_px = hn::Set(f, 1.0F / field.px_per_rad);
  const auto half = hn::Set(f, 0.5F), one = hn::Set(f, 1.0F), zero = hn::Zero(f);
  const auto width = hn::Set(f, static_cast<float>(field.width));
  const auto height = hn::Set(f, static_cast<float>(field.height));
  for (std::size_t i = 0; i < count; i += hn::Lanes(f)) {
    const auto rx = hn::LoadU(f, x + i), ry = hn::LoadU(f, y + i), rz = hn::LoadU(f, z + i);
    if (hn::AllFalse(f, hn::Eq(rx, rx))) {  // nothing seen here
      hn::StoreU(unknown, f, range_m + i);
      hn::StoreU(unknown, f, sd_m + i);
      continue;
    }
    const auto turned = [&](int row) {
      return hn::MulAdd(
          hn::Set(f, m[3 * row]), rx,
          hn::MulAdd(hn::Set(f, m[3 * row + 1]), ry, hn::Mul(hn::Set(f, m[3 * row + 2]), rz)));
    };
    const auto pole = turned(0), up = turned(1), side = turned(2);
    const auto across = hn::Sqrt(hn::MulAdd(up, up, hn::Mul(side, side)));
    const auto alpha = AngleTo(across, pole);
    const auto from_up = AngleTo(hn::Abs(side), up);
    const auto beta =
        hn::IfThenElse(hn::Lt(side, zero), hn::Sub(hn::Set(f, 2 * kPi), from_up), from_up);
    const auto column = hn::Mul(hn::Sub(alpha, hn::Set(f, field.first_alpha_rad)), px_per_rad);
    const auto row = hn::Sub(hn::Mul(beta, px_per_rad), half);
    // False for NaN.
    const auto inside = hn::And(hn::And(hn::Ge(column, zero), hn::Lt(column, hn::Sub(width, one))),
                                hn::And(hn::Ge(row, zero), hn::Lt(row, hn::Sub(height, one))));
    if (hn::AllFalse(f, inside)) {
      hn::StoreU(unknown, f, range_m + i);
      hn::StoreU(unknown, f, sd_m + i);
      continue;
    }
    const auto safe_column = hn::IfThenElseZero(inside, column);
    const auto safe_row = hn::IfThenElseZero(inside, row);
    const auto left = hn::ConvertTo(i32, safe_column), top = hn::ConvertTo(i32, safe_row);
    const auto right_part = hn::Sub(safe_column, hn::ConvertTo(f, left));
    const auto low_part = hn::Sub(safe_row, hn::ConvertTo(f, top));
    const auto index = hn::Add(hn::Mul(top, hn::Set(i32, field.width)), left);
    const auto d00 = hn::GatherIndex(f, field.disparity_px, index);
    const auto d01 = hn::GatherIndex(f, field.disparity_px + 1, index);
    const auto d10 = hn::GatherIndex(f, field.disparity_px + field.width, index);
    const auto d11 = hn::GatherIndex(f, field.disparity_px + field.width + 1, index);
    // The nearest of the four decides which surface it is.
    const auto to_right = hn::Gt(right_part, half), to_low = hn::Gt(low_part, half);
    const auto nearest = hn::IfThenElse(to_low, hn::IfThenElse(to_right, d11, d10),
                                        hn::IfThenElse(to_right, d01, d00));
    const auto w_right = right_part, w_left = hn::Sub(one, right_part);
    const auto w_low = low_part, w_top = hn::Sub(one, low_part);
    auto weight = zero, sum = zero;
    const auto add = [&](auto d, auto w) {
      const auto same =
          hn::And(hn::Ge(d, zero), hn::Lt(hn::Abs(hn::Sub(d, nearest)), hn::Set(f, kSameSurface)));
      const auto used = hn::IfThenElseZero(same, w);
      weight = hn::Add(weight, used);
      sum = hn::MulAdd(used, d, sum);
    };
    add(d00, hn::Mul(w_left, w_top));
    add(d01, hn::Mul(w_right, w_top));
    add(d10, hn::Mul(w_left, w_low));
    add(d11, hn::Mul(w_right, w_low));
    const auto nearest_index = hn::Add(
        index, hn::Add(hn::IfThenElseZero(hn::RebindMask(i32, to_right), hn::Set(i32, 1)),
                       hn::IfThenElseZero(hn::RebindMask(i32, to_low), hn::Set(i32, field.width))));
    const auto sd_px = hn::GatherIndex(f, field.sd_px, nearest_index);
    const auto delta = hn::Mul(hn::Div(sum, hn::Max(weight, hn::Set(f, 1e-6F))), rad_per_px);
    const auto known =
        hn::And(hn::And(inside, hn::Ge(nearest, zero)), hn::Gt(delta, hn::Set(f, 1e-6F)));
    // Sine rule: range = baseline sin(alpha + delta) / sin(delta).
    const auto sine = hn::Sin(f, delta);
    const auto baseline = hn::Set(f, field.baseline_m);
    const auto inverse = hn::Div(one, hn::Max(sine, hn::Set(f, 1e-9F)));
    const auto range =
        hn::Mul(baseline, hn::MulAdd(hn::Mul(across, hn::Cos(f, delta)), inverse, pole));
    const auto slope = hn::Mul(baseline, hn::Mul(across, hn::Mul(inverse, inverse)));
    const auto good = hn::And(known, hn::Gt(range, zero));
    hn::StoreU(hn::IfThenElse(good, range, unknown), f, range_m + i);
    const auto by_match = hn::Mul(slope, hn::Mul(sd_px, rad_per_px));
    const auto by_turn = hn::Mul(slope, hn::Set(f, field.turn_sd_rad));
    const auto by_length = hn::Mul(range, hn::Set(f, field.length_relative_sd));
    const auto variance =
        hn::MulAdd(by_match, by_match, hn::MulAdd(by_turn, by_turn, hn::Mul(by_length, by_length)));
    hn::StoreU(hn::IfThenElse(good, hn::Sqrt(variance), unknown), f, sd_m + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kawara::vision::range
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kawara::vision::range {

HWY_EXPORT(RangesOfRow);

void RangesOfRow(const FieldView& field, const float* x, const float* y, const float* z,
                 std::size_t count, float* range_m, float* sd_m) {
  HWY_DYNAMIC_DISPATCH(RangesOfRow)(field, x, y, z, count, range_m, sd_m);
}

}  // namespace kawara::vision::range
#endif  // HWY_ONCE
