// Included once for each SIMD target, so with a guard of Highway's kind instead of #pragma once.
#if defined(KAWARA_SIM_RENDER_LANE_MATH_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef KAWARA_SIM_RENDER_LANE_MATH_INL
#undef KAWARA_SIM_RENDER_LANE_MATH_INL
#else
#define KAWARA_SIM_RENDER_LANE_MATH_INL
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

/// Arithmetic on several rays at once that reads like arithmetic on one: a lane is a ray. Sums,
/// products, quotients and roots are those of IEEE 754 in the order written, never fused, so every
/// target and every lane gives the same bits; files that use this are compiled with
/// -ffp-contract=off.
HWY_BEFORE_NAMESPACE();
namespace kawara::sim::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::CappedTag<float, 16>;
using IntTag = hn::RebindToSigned<FloatTag>;
using BitsTag = hn::RebindToUnsigned<FloatTag>;

/// Single floats.
struct F {
  hn::Vec<FloatTag> v;
  HWY_INLINE F() : v(hn::Zero(FloatTag())) {}
  HWY_INLINE F(float x) : v(hn::Set(FloatTag(), x)) {}  // NOLINT: constants are numbers
  HWY_INLINE explicit F(hn::Vec<FloatTag> x) : v(x) {}
};
/// 32 bits, arithmetic modulo 2^32.
struct U {
  hn::Vec<BitsTag> v;
  HWY_INLINE U(std::uint32_t x) : v(hn::Set(BitsTag(), x)) {}  // NOLINT
  HWY_INLINE explicit U(hn::Vec<BitsTag> x) : v(x) {}
};
/// Yes or no.
struct Is {
  hn::Mask<FloatTag> m;
};

HWY_INLINE F operator+(F a, F b) { return F(hn::Add(a.v, b.v)); }
HWY_INLINE F operator-(F a, F b) { return F(hn::Sub(a.v, b.v)); }
HWY_INLINE F operator*(F a, F b) { return F(hn::Mul(a.v, b.v)); }
HWY_INLINE F operator/(F a, F b) { return F(hn::Div(a.v, b.v)); }
HWY_INLINE F operator-(F a) { return F(hn::Neg(a.v)); }
HWY_INLINE F& operator+=(F& a, F b) { return a = a + b; }
HWY_INLINE F& operator-=(F& a, F b) { return a = a - b; }
HWY_INLINE F& operator*=(F& a, F b) { return a = a * b; }
HWY_INLINE Is operator<(F a, F b) { return {hn::Lt(a.v, b.v)}; }
HWY_INLINE Is operator>(F a, F b) { return {hn::Gt(a.v, b.v)}; }
HWY_INLINE Is Both(Is a, Is b) { return {hn::And(a.m, b.m)}; }
HWY_INLINE bool Nowhere(Is a) { return hn::AllFalse(FloatTag(), a.m); }
HWY_INLINE F Select(Is yes, F a, F b) { return F(hn::IfThenElse(yes.m, a.v, b.v)); }
HWY_INLINE U Select(Is yes, U a, U b) {
  return U(hn::IfThenElse(hn::RebindMask(BitsTag(), yes.m), a.v, b.v));
}
HWY_INLINE U operator+(U a, U b) { return U(hn::Add(a.v, b.v)); }
HWY_INLINE U operator*(U a, U b) { return U(hn::Mul(a.v, b.v)); }
HWY_INLINE U operator^(U a, U b) { return U(hn::Xor(a.v, b.v)); }
HWY_INLINE U operator&(U a, U b) { return U(hn::And(a.v, b.v)); }
template <int kBits>
HWY_INLINE U Right(U a) {
  return U(hn::ShiftRight<kBits>(a.v));
}

HWY_INLINE F Abs(F x) { return F(hn::Abs(x.v)); }
HWY_INLINE F Min(F a, F b) { return F(hn::Min(a.v, b.v)); }
HWY_INLINE F Max(F a, F b) { return F(hn::Max(a.v, b.v)); }
HWY_INLINE F Sqrt(F x) { return F(hn::Sqrt(x.v)); }
HWY_INLINE F Floor(F x) { return F(hn::Floor(x.v)); }
/// Of whole numbers.
HWY_INLINE U BitsOf(F whole) { return U(hn::BitCast(BitsTag(), hn::ConvertTo(IntTag(), whole.v))); }
/// Of bits that are less than 2^31.
HWY_INLINE F FloatOf(U small) {
  return F(hn::ConvertTo(FloatTag(), hn::BitCast(IntTag(), small.v)));
}
HWY_INLINE F Mix(F a, F b, F share_of_b) { return a + (b - a) * share_of_b; }
HWY_INLINE F Smooth(F t) { return t * t * (F(3.0F) - F(2.0F) * t); }
HWY_INLINE F SmoothStep(F low, F high, F x) {
  return Smooth(Min(Max((x - low) / (high - low), 0.0F), 1.0F));
}
HWY_INLINE F SmoothStep(float low, float high, F x) {
  return Smooth(Min(Max((x - low) * F(1.0F / (high - low)), 0.0F), 1.0F));
}

// What follows says for many lanes what noise2.hpp says for one.

HWY_INLINE U MixBits(U h) {
  h = (h ^ Right<16>(h)) * U(0x7FEB352DU);
  h = (h ^ Right<15>(h)) * U(0x846CA68BU);
  return h ^ Right<16>(h);
}
HWY_INLINE U SumOfCell(U x, U y, U seed) {
  return x * U(0x9E3779B1U) + y * U(0x85EBCA77U) + seed * U(0xC2B2AE3DU);
}
HWY_INLINE U HashOf(U x, U y, U seed) { return MixBits(SumOfCell(x, y, seed)); }
HWY_INLINE F UnitOf(U hash) { return FloatOf(Right<8>(hash)) * F(1.0F / 16777216.0F); }

HWY_INLINE F Noise(F x, F y, U seed) {
  const F i = Floor(x);
  const F j = Floor(y);
  const F sx = Smooth(x - i);
  const F sy = Smooth(y - j);
  const U h00 = SumOfCell(BitsOf(i), BitsOf(j), seed);
  const U h10 = h00 + U(0x9E3779B1U);
  const F low = Mix(UnitOf(MixBits(h00)), UnitOf(MixBits(h10)), sx);
  const F high =
      Mix(UnitOf(MixBits(h00 + U(0x85EBCA77U))), UnitOf(MixBits(h10 + U(0x85EBCA77U))), sx);
  return F(2.0F) * Mix(low, high, sy) - F(1.0F);
}

/// How much of a detail is left of which a footprint takes in `details` (its size over the
/// footprint's).
HWY_INLINE F DetailLeft(F details) { return SmoothStep(1.25F, 3.0F, details); }

/// Octaves from `wavelength` down, each half as long and `persistence` times as strong; the first
/// that no lane's footprint leaves anything of ends it.
HWY_NOINLINE inline F Fractal(F u, F v, float wavelength, int octaves, float persistence,
                              F inverse_footprint, U seed) {
  F sum;
  float strength = 1.0F;
  float length = wavelength;
  for (int k = 0; k < octaves; ++k) {
    const F left = DetailLeft(F(length) * inverse_footprint);
    if (Nowhere(left > F(0.0F))) break;
    sum += F(strength) * left *
           Noise(u * F(1.0F / length), v * F(1.0F / length),
                 seed + U(131U * static_cast<std::uint32_t>(k)));
    strength *= persistence;
    length *= 0.5F;
  }
  return sum;
}

/// sin(2 pi turns) to 0.0012, for any turns: two parabolas, and their square to correct them.
HWY_INLINE F SinOfTurns(F turns) {
  const F x = turns - Floor(turns + F(0.5F));  // -0.5..0.5
  const F y = F(8.0F) * x - F(16.0F) * x * Abs(x);
  return y + F(0.225F) * (y * Abs(y) - y);
}

}  // namespace kawara::sim::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
