#include "sim/render/noise2.hpp"

#include <cstddef>

// Highway compiles this file once for each SIMD target; the table of targets is at the bottom.
// The build forbids fused multiply-adds here: they would round differently where they exist.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/render/noise2.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kawara::sim {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kOctaves = 8;
alignas(32) constexpr float kHalvings[kOctaves] = {1.0F,    0.5F,     0.25F,     0.125F,
                                                   0.0625F, 0.03125F, 0.015625F, 0.0078125F};
alignas(32) constexpr float kDoublings[kOctaves] = {1.0F,  2.0F,  4.0F,  8.0F,
                                                    16.0F, 32.0F, 64.0F, 128.0F};
alignas(32) constexpr std::uint32_t kSeedSteps[kOctaves] = {0, 131, 262, 393, 524, 655, 786, 917};

// HashCell of lattice points whose sum of multiples is `h`, as UnitFromHash gives it.
template <class DU>
HWY_INLINE hn::Vec<hn::RebindToFloat<DU>> UnitOf(DU du, hn::Vec<DU> h) {
  const hn::RebindToFloat<DU> df;
  const hn::RebindToSigned<DU> di;
  h = hn::Mul(hn::Xor(h, hn::ShiftRight<16>(h)), hn::Set(du, 0x7FEB352DU));
  h = hn::Mul(hn::Xor(h, hn::ShiftRight<15>(h)), hn::Set(du, 0x846CA68BU));
  h = hn::Xor(h, hn::ShiftRight<16>(h));
  return hn::Mul(hn::ConvertTo(df, hn::BitCast(di, hn::ShiftRight<8>(h))),
                 hn::Set(df, 1.0F / 16777216.0F));
}

template <class DF>
HWY_INLINE hn::Vec<DF> Smooth(DF df, hn::Vec<DF> t) {
  return hn::Mul(hn::Mul(t, t), hn::Sub(hn::Set(df, 3.0F), hn::Mul(hn::Set(df, 2.0F), t)));
}

template <class V>
HWY_INLINE V Between(V a, V b, V share) {
  return hn::Add(a, hn::Mul(hn::Sub(b, a), share));
}

// What the scalar functions of noise2.hpp say, an octave a lane; term[k] = octave k's share.
void Octaves(float u, float v, float wavelength, float footprint, std::uint32_t seed,
             const float* HWY_RESTRICT strength, float* HWY_RESTRICT term) {
  const hn::CappedTag<float, kOctaves> df;
  const hn::RebindToUnsigned<decltype(df)> du;
  const hn::RebindToSigned<decltype(df)> di;
  const auto one = hn::Set(df, 1.0F);
  const auto zero = hn::Zero(df);
  for (std::size_t k = 0; k < kOctaves; k += hn::Lanes(df)) {
    const auto detail = hn::Mul(hn::Load(df, kHalvings + k), hn::Set(df, wavelength / footprint));
    const auto t = hn::Mul(hn::Sub(detail, hn::Set(df, 1.25F)), hn::Set(df, 1.0F / 1.75F));
    const auto left = Smooth(df, hn::Min(hn::Max(t, zero), one));
    const auto frequency = hn::Mul(hn::Load(df, kDoublings + k), hn::Set(df, 1.0F / wavelength));
    const auto x = hn::Mul(hn::Set(df, u), frequency);
    const auto y = hn::Mul(hn::Set(df, v), frequency);
    const auto floor_x = hn::Floor(x);
    const auto floor_y = hn::Floor(y);
    const auto i = hn::BitCast(du, hn::ConvertTo(di, floor_x));
    const auto j = hn::BitCast(du, hn::ConvertTo(di, floor_y));
    const auto sx = Smooth(df, hn::Sub(x, floor_x));
    const auto sy = Smooth(df, hn::Sub(y, floor_y));
    const auto step_x = hn::Set(du, 0x9E3779B1U);
    const auto step_y = hn::Set(du, 0x85EBCA77U);
    const auto seeds =
        hn::Mul(hn::Add(hn::Set(du, seed), hn::Load(du, kSeedSteps + k)), hn::Set(du, 0xC2B2AE3DU));
    const auto h00 = hn::Add(hn::Add(hn::Mul(i, step_x), hn::Mul(j, step_y)), seeds);
    const auto h10 = hn::Add(h00, step_x);
    const auto low = Between(UnitOf(du, h00), UnitOf(du, h10), sx);
    const auto high =
        Between(UnitOf(du, hn::Add(h00, step_y)), UnitOf(du, hn::Add(h10, step_y)), sx);
    const auto noise = hn::Sub(hn::Mul(hn::Set(df, 2.0F), Between(low, high, sy)), one);
    hn::Store(hn::Mul(hn::Mul(hn::Load(df, strength + k), left), noise), df, term + k);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kawara::sim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kawara::sim {

HWY_EXPORT(Octaves);

float Fractal2(float u_m, float v_m, float wavelength_m, int octaves, float persistence,
               float footprint_m, std::uint32_t seed) {
  constexpr int kMost = 8;
  const float footprint = std::max(footprint_m, 1e-6F);
  if (DetailLeft(wavelength_m, footprint) <= 0.0F) return 0.0F;
  const float p = persistence;
  const float p2 = p * p;
  const float p4 = p2 * p2;
  alignas(32) float strength[kMost] = {1.0F, p, p2, p2 * p, p4, p4 * p, p4 * p2, p4 * p2 * p};
  for (int k = octaves; k < kMost; ++k) strength[k] = 0.0F;
  alignas(32) float term[kMost];
  HWY_DYNAMIC_DISPATCH(Octaves)(u_m, v_m, wavelength_m, footprint, seed, strength, term);
  // In this order on every target.
  return ((term[0] + term[1]) + (term[2] + term[3])) + ((term[4] + term[5]) + (term[6] + term[7]));
}

}  // namespace kawara::sim
#endif
