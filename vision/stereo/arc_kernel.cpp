#include "vision/stereo/arc_kernel.hpp"

#include <limits>

// Highway compiles this file once for each SIMD target; the table of targets is at the bottom.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/stereo/arc_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kawara::vision::paper {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 16>;
using I = hn::Rebind<std::int32_t, F>;

void ProjectArc(const RadialTable& table, const Arc& arc, const float* cosine, const float* sine,
                std::size_t count, const ArcPixels& out) {
  const F f;
  const I i32;
  const auto nowhere = hn::Set(f, std::numeric_limits<float>::quiet_NaN());
  const auto z_min = hn::Set(f, table.z_min), z_max = hn::Set(f, table.z_max);
  const auto last = hn::Set(i32, table.count - 2);
  const auto zero = hn::Zero(i32);
  const auto step = hn::Set(f, table.inverse_step);
  for (std::size_t i = 0; i < count; i += hn::Lanes(f)) {
    const auto c = hn::LoadU(f, cosine + i), s = hn::LoadU(f, sine + i);
    const auto along = [&](std::size_t k) {
      return hn::MulAdd(hn::Set(f, arc.start[k]), c, hn::Mul(hn::Set(f, arc.turn[k]), s));
    };
    const auto x = along(0), y = along(1), z = along(2);
    const auto inside = hn::And(hn::Ge(z, z_min), hn::Le(z, z_max));
    const auto at = hn::Mul(hn::Sub(z, z_min), step);
    const auto knot = hn::Max(zero, hn::Min(hn::ConvertTo(i32, at), last));
    const auto left = hn::GatherIndex(f, table.knots, knot);
    const auto rise = hn::Sub(hn::GatherIndex(f, table.knots + 1, knot), left);
    const auto g = hn::MulAdd(hn::Sub(at, hn::ConvertTo(f, knot)), rise, left);
    // d of the ray turning towards up, and of (x, y) g(z) with it.
    const auto up_along =
        hn::MulAdd(hn::Set(f, arc.up[0]), x,
                   hn::MulAdd(hn::Set(f, arc.up[1]), y, hn::Mul(hn::Set(f, arc.up[2]), z)));
    const auto dx = hn::NegMulAdd(up_along, x, hn::Set(f, arc.up[0]));
    const auto dy = hn::NegMulAdd(up_along, y, hn::Set(f, arc.up[1]));
    const auto dz = hn::NegMulAdd(up_along, z, hn::Set(f, arc.up[2]));
    const auto dg = hn::Mul(hn::Mul(rise, step), dz);
    const auto du = hn::MulAdd(g, dx, hn::Mul(dg, x)), dv = hn::MulAdd(g, dy, hn::Mul(dg, y));
    const auto affine = [&](std::size_t k, auto of_x, auto of_y) {
      return hn::MulAdd(hn::Set(f, table.affine[k]), of_x,
                        hn::Mul(hn::Set(f, table.affine[k + 1]), of_y));
    };
    const auto u = hn::MulAdd(g, affine(0, x, y), hn::Set(f, table.center_u_px));
    const auto v = hn::MulAdd(g, affine(2, x, y), hn::Set(f, table.center_v_px));
    hn::StoreU(hn::IfThenElse(inside, u, nowhere), f, out.u_px + i);
    hn::StoreU(hn::IfThenElse(inside, v, nowhere), f, out.v_px + i);
    hn::StoreU(affine(0, du, dv), f, out.up_u + i);
    hn::StoreU(affine(2, du, dv), f, out.up_v + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kawara::vision::paper
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kawara::vision::paper {

HWY_EXPORT(ProjectArc);

void ProjectArc(const RadialTable& table, const Arc& arc, const float* cosine, const float* sine,
                std::size_t count, const ArcPixels& out) {
  HWY_DYNAMIC_DISPATCH(ProjectArc)(table, arc, cosine, sine, count, out);
}

}  // namespace kawara::vision::paper
#endif  // HWY_ONCE
