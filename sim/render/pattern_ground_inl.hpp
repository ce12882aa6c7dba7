#if defined(KAWARA_SIM_RENDER_PATTERN_GROUND_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef KAWARA_SIM_RENDER_PATTERN_GROUND_INL
#undef KAWARA_SIM_RENDER_PATTERN_GROUND_INL
#else
#define KAWARA_SIM_RENDER_PATTERN_GROUND_INL
#endif

#include "sim/render/pattern_tools_inl.hpp"

/// Inside of surface_pattern: what lies on the ground or grows from it, and clothes. One function a
/// family; all in linear reflectance.
HWY_BEFORE_NAMESPACE();
namespace kawara::sim::HWY_NAMESPACE {

/// Thin dark lines along the zeros of a bent noise; `width_m` wide, averaged over the footprint.
HWY_INLINE F Cracks(const PatternPlace& p, float wavelength_m, float width_m, std::uint32_t salt) {
  const F blur_m = Max(p.width, 0.3F * width_m);
  const F share = Min(F(width_m) / blur_m, 1.0F);
  // Not everywhere: whole parts of a road are sound.
  const F where = SmoothStep(0.1F, 0.5F, NoiseAt(p, 7.0F, 7.0F, salt + 3U));
  const F seen = Select(share < F(0.03F), F(0.0F), share * where);
  if (Nowhere(seen > F(0.0F))) return 0.0F;
  const F u = p.u + F(0.35F) * NoiseAt(p, 0.4F, 0.4F, salt + 1U);
  const F v = p.v + F(0.35F) * NoiseAt(p, 0.4F, 0.4F, salt + 2U);
  const F value = Noise(u * F(1.0F / wavelength_m), v * F(1.0F / wavelength_m), U(p.seed + salt));
  // The noise crosses zero with a slope of about 1.5 a wavelength.
  const F distance_m = Abs(value) * F(wavelength_m / 1.5F);
  const F half = 0.5F * width_m;
  return seen * (F(1.0F) - SmoothStep(half, half + blur_m, distance_m));
}

HWY_INLINE Look AsphaltLook(const PatternPlace& p) {
  Look c;
  // Stones of 8 to 12 mm in dark binder, worn light where wheels run; tone changes over metres.
  F tone = F(0.055F) * FractalAt(p, 3.6F, 8, 1.03F, 1U);
  Rgb colour = p.base;
  const F stones = Seen(p, 0.012F);
  if (!Nowhere(stones > F(0.0F))) {
    const NearestCells stone =
        FindCells(p.u * F(1.0F / 0.011F), p.v * F(1.0F / 0.011F), U(p.seed + 3U));
    const F light = UnitOf(stone.hash * U(0x9E3779B1U));
    colour = Blend(colour, p.second,
                   F(0.6F * p.contrast) * stones * (SmoothStep(0.5F, 1.0F, light) - F(0.25F)));
    tone += stones * (F(0.25F) * (light - F(0.5F)) +
                      F(0.30F) * (F(0.5F) - SmoothStep(0.2F, 0.7F, stone.first)));
  }
  // A mended rectangle here and there, of newer, darker stuff.
  constexpr float kCell_m = 6.5F;
  const F i = Floor(p.u * F(1.0F / kCell_m));
  const F j = Floor(p.v * F(1.0F / kCell_m));
  const U hash = HashOf(BitsOf(i), BitsOf(j), U(p.seed + 4U));
  const Is mended = UnitOf(hash) < F(0.22F);
  if (!Nowhere(mended)) {
    const F half_u = F(0.4F) + F(1.5F) * UnitOf(hash * U(0x9E3779B1U));
    const F half_v = F(0.4F) + F(0.9F) * UnitOf(hash * U(0x85EBCA77U));
    const F du = Abs(p.u - (i + F(0.5F)) * F(kCell_m)) - half_u;
    const F dv = Abs(p.v - (j + F(0.5F)) * F(kCell_m)) - half_v;
    const F edge = Max(du, dv) + F(0.02F) * NoiseAt(p, 0.1F, 0.1F, 5U);
    const F blur = Max(F(0.5F) * p.width, 0.01F);
    const F inside = F(1.0F) - SmoothStep(-blur, blur, edge);
    const F rim = (F(1.0F) - SmoothStep(F(0.02F), F(0.02F) + blur, Abs(edge))) *
                  Min(F(0.04F) / (F(0.04F) + blur), 1.0F);
    tone -= Select(mended, F(0.26F) * inside + F(0.30F) * rim, F(0.0F));
  }
  // Oil where something stood: the high end of a slow noise, ragged by the tone itself.
  const F oil = Seen(p, 1.3F) * NoiseAt(p, 1.3F, 1.3F, 6U);
  tone -= F(0.35F) * SmoothStep(0.55F, 1.0F, oil + F(2.0F) * tone);
  const F cracks = Cracks(p, 2.6F, 0.010F, 60U);
  c.rgb = colour * ((F(1.0F) + F(p.contrast) * tone) *
                    (F(1.0F) - F(0.65F * std::min(1.0F, p.contrast)) * cracks));
  c.gloss = p.material.gloss;
  return c;
}

HWY_INLINE Look SoilLook(const PatternPlace& p) {
  Look c;
  const F broad = FractalAt(p, 2.6F, 3, 0.6F, 1U);
  const F crumbs = F(0.85F) * FractalAt(p, 0.6F, 7, 1.0F, 2U);
  const Rgb colour = Blend(p.base, p.second, SmoothStep(-0.3F, 0.9F, broad));
  F tone = F(0.17F) * crumbs;
  const float size_m = std::clamp(0.5F * p.material.scale_m, 0.01F, 0.10F);
  const F pebbles = Seen(p, size_m);
  if (!Nowhere(pebbles > F(0.0F))) {
    const NearestCells pebble =
        FindCells(p.u * F(1.0F / size_m), p.v * F(1.0F / size_m), U(p.seed + 3U));
    const F kind = UnitOf(pebble.hash * U(0x9E3779B1U));
    const F inside = F(1.0F) - SmoothStep(0.30F, 0.42F, pebble.first);
    tone += pebbles * (inside * (F(0.9F) * kind - F(0.35F)) - F(0.12F));
    c.slope_u = F(0.35F) * pebbles * inside * (UnitOf(pebble.hash * U(0x85EBCA77U)) - F(0.5F));
  }
  c.rgb = colour * (F(1.0F) + F(p.contrast) * tone);
  c.gloss = p.material.gloss;
  return c;
}

HWY_INLINE Look GrassLook(const PatternPlace& p) {
  Look c;
  const F broad = FractalAt(p, 1.8F, 3, 0.6F, 1U);
  const F tufts = FractalAt(p, 0.22F, 3, 0.75F, 2U);
  // Blades: thin and of any direction; two crossed sets of drawn-out noise.
  const F seen = Seen(p, 0.015F);
  F blades;
  if (!Nowhere(seen > F(0.0F))) {
    const F a = Noise((p.u + F(0.6F) * p.v) * F(1.0F / 0.010F),
                      (p.v - F(0.6F) * p.u) * F(1.0F / 0.07F), U(p.seed + 3U));
    const F b = Noise((p.u - F(0.8F) * p.v) * F(1.0F / 0.010F),
                      (p.v + F(0.8F) * p.u) * F(1.0F / 0.07F), U(p.seed + 4U));
    blades = seen * (Max(a, b) - F(0.22F));  // less its mean
  }
  c.rgb = Blend(p.base, p.second, SmoothStep(-1.1F, 1.1F, broad + F(0.5F) * tufts)) *
          (F(1.0F) + F(p.contrast) * (F(0.30F) * tufts + F(0.45F) * blades));
  c.slope_u = F(0.30F) * tufts;
  c.slope_v = F(0.30F) * blades;
  c.luminance = 0.15F;
  c.gloss = p.material.gloss;
  return c;
}

HWY_INLINE Look LeavesLook(const PatternPlace& p) {
  Look c;
  const float leaf_m = std::clamp(p.material.scale_m, 0.03F, 0.3F);
  const F clumps = FractalAt(p, 0.9F, 3, 0.65F, 1U);
  const F seen = Seen(p, leaf_m);
  // What leaves and gaps come to when they cannot be told apart any more.
  F tone = F(0.45F) * clumps - F(0.19F) * (F(1.0F) - seen);
  F share_of_second = F(0.35F) * (F(1.0F) - seen);
  if (!Nowhere(seen > F(0.0F))) {
    // Two layers: leaves in front, and in the gaps between them darkness and leaves behind.
    const NearestCells front =
        FindCells(p.u * F(1.0F / leaf_m), p.v * F(1.0F / leaf_m), U(p.seed + 2U));
    const F kind = UnitOf(front.hash * U(0x9E3779B1U));
    const F gap = SmoothStep(0.36F, 0.60F, front.first);
    const F behind = NoiseAt(p, 0.6F * leaf_m, 0.6F * leaf_m, 3U);
    share_of_second += seen * F(0.7F) * kind;
    tone += seen * Mix(F(0.6F) * (kind - F(0.45F)), F(-0.62F) + F(0.15F) * behind, gap);
    c.slope_u = seen * F(1.1F) * (UnitOf(front.hash * U(0x85EBCA77U)) - F(0.5F));
    c.slope_v = seen * F(1.1F) * (UnitOf(front.hash * U(0xC2B2AE3DU)) - F(0.5F));
  }
  c.rgb = Blend(p.base, p.second, share_of_second) *
          Max(F(1.0F) + F(p.contrast) * (tone - F(0.12F)), 0.08F);
  c.luminance = 0.35F;
  c.gloss = p.material.gloss;
  return c;
}

HWY_INLINE Look RubbleLook(const PatternPlace& p) {
  Look c;
  const float chunk_m = std::clamp(p.material.scale_m, 0.05F, 2.0F);
  // Lumps in two sizes, the smaller filling the gaps of the larger.
  NearestCells lump = FindCells(p.u * F(1.0F / chunk_m), p.v * F(1.0F / chunk_m), U(p.seed + 1U));
  F size_m = chunk_m;
  const Is between = lump.second - lump.first < F(0.16F);
  if (!Nowhere(between)) {
    const float small_m = 0.3F * chunk_m;
    const NearestCells small =
        FindCells(p.u * F(1.0F / small_m), p.v * F(1.0F / small_m), U(p.seed + 2U));
    lump.first = Select(between, small.first, lump.first);
    lump.second = Select(between, small.second, lump.second);
    lump.hash = Select(between, small.hash, lump.hash);
    size_m = Select(between, F(small_m), size_m);
  }
  const F seen = DetailLeft(size_m * p.per_width);
  const F kind = UnitOf(lump.hash * U(0x9E3779B1U));
  const F tone = UnitOf(lump.hash * U(0x85EBCA77U)) - F(0.5F);
  // Mostly the base (broken concrete), some of the second tone, some brick, plaster and wood.
  Rgb colour = Select(kind > F(0.60F), p.second, p.base);
  colour = Select(kind > F(0.80F), Rgb{0.36F, 0.15F, 0.09F}, colour);
  colour = Select(kind > F(0.88F), Rgb{0.62F, 0.60F, 0.55F}, colour);
  colour = Select(kind > F(0.95F), Rgb{0.28F, 0.19F, 0.11F}, colour);
  const float contrast = std::min(1.0F, p.contrast);
  colour = Blend(Blend(p.base, p.second, 0.3F), colour, seen * F(contrast));
  const F dust = FractalAt(p, 0.25F * chunk_m, 4, 0.75F, 3U);
  const F gap = seen * (F(1.0F) - SmoothStep(0.0F, 0.22F, lump.second - lump.first));
  c.rgb = colour * ((F(1.0F) + F(p.contrast) * (F(0.5F) * seen * tone + F(0.18F) * dust)) *
                    (F(1.0F) - F(0.75F * contrast) * gap));
  c.slope_u = seen * (UnitOf(lump.hash * U(0xC2B2AE3DU)) - F(0.5F)) + F(0.2F) * dust;
  c.slope_v = seen * (UnitOf(lump.hash * U(0x27D4EB2FU)) - F(0.5F));
  c.gloss = p.material.gloss;
  return c;
}

HWY_INLINE Look ClothLook(const PatternPlace& p) {
  Look c;
  const F bend = F(0.8F) * NoiseAt(p, 0.3F, 0.25F, 0U);
  const F folds =
      Seen(p, 0.08F) * Noise(p.u * F(1.0F / 0.09F) + bend, p.v * F(1.0F / 0.35F), U(p.seed + 1U));
  const F weave = FractalAt(p, 0.03F, 3, 0.7F, 2U);
  const F patch = Seen(p, 0.35F) * NoiseAt(p, 0.5F, 0.3F, 3U);
  c.rgb = Blend(p.base, p.second, F(0.5F) * SmoothStep(0.35F, 0.5F, patch)) *
          (F(1.0F) + F(p.contrast) * (F(0.16F) * folds + F(0.08F) * weave));
  c.slope_u = F(0.45F) * folds;
  c.gloss = p.material.gloss;
  return c;
}

}  // namespace kawara::sim::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
