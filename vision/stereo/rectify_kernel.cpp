#include "vision/stereo/rectify_kernel.hpp"

#include <limits>

// Highway compiles this file once for each SIMD target; the table of targets is at the bottom.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/stereo/rectify_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kawara::vision::rectify {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Rows are padded to whole vectors of at most 16 lanes.
using F = hn::CappedTag<float, 16>;
using I = hn::Rebind<std::int32_t, F>;
using U = hn::Rebind<std::uint32_t, F>;

void ProjectRow(const RadialTable& table, const Meridian& meridian, const float* cosine,
                const float* sine, std::size_t count, float* u_px, float* v_px) {
  const F f;
  const I i32;
  const auto nowhere = hn::Set(f, std::numeric_limits<float>::quiet_NaN());
  const auto z_min = hn::Set(f, table.z_min), z_max = hn::Set(f, table.z_max);
  const auto last = hn::Set(i32, table.count - 2);
  const auto zero = hn::Zero(i32);
  const auto along = [&](std::size_t k, auto c, auto s) {
    return hn::MulAdd(hn::Set(f, meridian.pole[k]), c, hn::Mul(hn::Set(f, meridian.side[k]), s));
  };
  for (std::size_t i = 0; i < count; i += hn::Lanes(f)) {
    const auto c = hn::LoadU(f, cosine + i), s = hn::LoadU(f, sine + i);
    const auto x = along(0, c, s), y = along(1, c, s), z = along(2, c, s);
    const auto inside = hn::And(hn::Ge(z, z_min), hn::Le(z, z_max));
    const auto at = hn::Mul(hn::Sub(z, z_min), hn::Set(f, table.inverse_step));
    const auto knot = hn::Max(zero, hn::Min(hn::ConvertTo(i32, at), last));
    const auto left = hn::GatherIndex(f, table.knots, knot);
    const auto right = hn::GatherIndex(f, table.knots + 1, knot);
    const auto g = hn::MulAdd(hn::Sub(at, hn::ConvertTo(f, knot)), hn::Sub(right, left), left);
    const auto u = hn::MulAdd(
        g, hn::MulAdd(hn::Set(f, table.affine[0]), x, hn::Mul(hn::Set(f, table.affine[1]), y)),
        hn::Set(f, table.center_u_px));
    const auto v = hn::MulAdd(
        g, hn::MulAdd(hn::Set(f, table.affine[2]), x, hn::Mul(hn::Set(f, table.affine[3]), y)),
        hn::Set(f, table.center_v_px));
    hn::StoreU(hn::IfThenElse(inside, u, nowhere), f, u_px + i);
    hn::StoreU(hn::IfThenElse(inside, v, nowhere), f, v_px + i);
  }
}

void SampleRow(const std::uint32_t* source, int width_px, int height_px, const float* u_px,
               const float* v_px, std::size_t count, std::uint32_t* target) {
  const F f;
  const I i32;
  const U u32;
  const auto u_max = hn::Set(f, static_cast<float>(width_px - 1));
  const auto v_max = hn::Set(f, static_cast<float>(height_px - 1));
  const auto stride = hn::Set(i32, width_px);
  const auto byte = hn::Set(u32, 0xFFU);
  const auto gather = [&](std::ptrdiff_t offset, auto index) {
    return hn::BitCast(
        u32, hn::GatherIndex(i32, reinterpret_cast<const std::int32_t*>(source) + offset, index));
  };
  for (std::size_t i = 0; i < count; i += hn::Lanes(f)) {
    const auto u = hn::LoadU(f, u_px + i), v = hn::LoadU(f, v_px + i);
    const auto zero = hn::Zero(f);
    // False for NaN. The last row and column are left to the pixels before them.
    const auto inside = hn::And(hn::And(hn::Ge(u, zero), hn::Lt(u, u_max)),
                                hn::And(hn::Ge(v, zero), hn::Lt(v, v_max)));
    if (hn::AllFalse(f, inside)) {
      hn::StoreU(hn::Zero(u32), u32, target + i);
      continue;
    }
    const auto safe_u = hn::IfThenElseZero(inside, u), safe_v = hn::IfThenElseZero(inside, v);
    const auto column = hn::ConvertTo(i32, safe_u), row = hn::ConvertTo(i32, safe_v);
    const auto right = hn::Sub(safe_u, hn::ConvertTo(f, column));
    const auto down = hn::Sub(safe_v, hn::ConvertTo(f, row));
    const auto index = hn::Add(hn::Mul(row, stride), column);
    const auto a = gather(0, index), b = gather(1, index);
    const auto c = gather(width_px, index), d = gather(width_px + 1, index);
    const auto all = hn::And(hn::And(a, b), hn::And(c, d));
    const auto seen = hn::And(
        hn::MaskFromVec(hn::BitCast(f, hn::BroadcastSignBit(hn::BitCast(i32, all)))), inside);
    auto pixel = hn::Set(u32, 0xFF000000U);
    const auto channel = [&](auto shifted) {
      return hn::ConvertTo(f, hn::BitCast(i32, hn::And(shifted, byte)));
    };
    const auto blend = [&](auto pa, auto pb, auto pc, auto pd) {
      const auto upper = hn::MulAdd(right, hn::Sub(pb, pa), pa);
      const auto lower = hn::MulAdd(right, hn::Sub(pd, pc), pc);
      const auto level = hn::MulAdd(down, hn::Sub(lower, upper), upper);
      return hn::BitCast(u32, hn::ConvertTo(i32, hn::Add(level, hn::Set(f, 0.5F))));
    };
    pixel = hn::Or(pixel, blend(channel(a), channel(b), channel(c), channel(d)));
    pixel = hn::Or(pixel, hn::ShiftLeft<8>(
                              blend(channel(hn::ShiftRight<8>(a)), channel(hn::ShiftRight<8>(b)),
                                    channel(hn::ShiftRight<8>(c)), channel(hn::ShiftRight<8>(d)))));
    pixel = hn::Or(pixel, hn::ShiftLeft<16>(blend(
                              channel(hn::ShiftRight<16>(a)), channel(hn::ShiftRight<16>(b)),
                              channel(hn::ShiftRight<16>(c)), channel(hn::ShiftRight<16>(d)))));
    hn::StoreU(hn::IfThenElseZero(hn::RebindMask(u32, seen), pixel), u32, target + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kawara::vision::rectify
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kawara::vision::rectify {

HWY_EXPORT(ProjectRow);
HWY_EXPORT(SampleRow);

void ProjectRow(const RadialTable& table, const Meridian& meridian, const float* cosine,
                const float* sine, std::size_t count, float* u_px, float* v_px) {
  HWY_DYNAMIC_DISPATCH(ProjectRow)(table, meridian, cosine, sine, count, u_px, v_px);
}

void SampleRow(const std::uint32_t* source, int width_px, int height_px, const float* u_px,
               const float* v_px, std::size_t count, std::uint32_t* target) {
  HWY_DYNAMIC_DISPATCH(SampleRow)(source, width_px, height_px, u_px, v_px, count, target);
}

}  // namespace kawara::vision::rectify
#endif  // HWY_ONCE
