#if defined(KAWARA_SIM_RENDER_PATTERN_MASONRY_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef KAWARA_SIM_RENDER_PATTERN_MASONRY_INL
#undef KAWARA_SIM_RENDER_PATTERN_MASONRY_INL
#else
#define KAWARA_SIM_RENDER_PATTERN_MASONRY_INL
#endif

#include "sim/render/pattern_tools_inl.hpp"

/// Inside of surface_pattern: walls and what is laid in courses: concrete, brick, tiles, sheet
/// metal, glass, boards, paint. One function a family; all in linear reflectance.
HWY_BEFORE_NAMESPACE();
namespace kawara::sim::HWY_NAMESPACE {

/// Rain runs down a wall: streaks narrow in u, long in v.
HWY_INLINE F Streaks(const PatternPlace& p, float width_m, float length_m, std::uint32_t salt) {
  const F seen = DetailLeft(F(width_m) * p.per_width_u);
  if (Nowhere(seen > F(0.0F))) return 0.0F;
  return seen * NoiseAt(p, width_m, length_m, salt);
}

/// Slow change of shade no real wall is without.
HWY_INLINE F Weather(const PatternPlace& p, float wavelength_m, int octaves) {
  return FractalAt(p, wavelength_m, octaves, 0.5F, 17U);
}

HWY_INLINE Look PlainLook(const PatternPlace& p) {
  Look c;
  c.rgb = p.base * (F(1.0F) + F(0.012F * p.contrast) * Weather(p, 3.0F, 2));
  c.gloss = p.material.gloss;
  return c;
}

HWY_INLINE Look ConcreteLook(const PatternPlace& p) {
  Look c;
  const float at_most_one = std::min(1.0F, p.contrast);
  // Blotches of metres down to grains of a centimetre; streaks; stains at the dark end of a noise.
  const F grain = FractalAt(p, 1.7F, 8, 0.95F, 31U);
  const F blotch = Seen(p, 1.1F) * NoiseAt(p, 1.1F, 1.1F, 53U);
  F tone = F(0.055F) * grain + F(0.05F) * blotch + F(0.06F) * Streaks(p, 0.22F, 2.4F, 41U);
  tone -= F(0.18F) * SmoothStep(0.40F, 0.95F, blotch + F(0.15F) * grain);
  const F pores = Seen(p, 0.02F);
  if (!Nowhere(pores > F(0.0F))) {
    tone -= F(0.25F) * pores * SmoothStep(0.62F, 0.75F, NoiseAt(p, 0.02F, 0.02F, 59U));
  }
  c.rgb = p.base * (F(1.0F) + F(p.contrast) * tone);
  const F warmth = F(p.contrast * 0.03F) * blotch;
  c.rgb.r *= F(1.0F) + warmth;
  c.rgb.g *= F(1.0F) + F(0.2F) * warmth;
  c.rgb.b *= F(1.0F) - warmth;
  if (p.material.scale_m > 0.05F) {
    const F joint = EitherJoint(JointShare(p.u, p.width_u, 2.0F * p.material.scale_m, 0.012F),
                                JointShare(p.v, p.width_v, p.material.scale_m, 0.012F));
    c.rgb = Blend(c.rgb, p.second * 0.7F, F(at_most_one) * joint);
  }
  c.slope_u = F(0.05F * p.contrast) * grain;
  c.gloss = p.material.gloss;
  return c;
}

HWY_INLINE Look BrickLook(const PatternPlace& p) {
  Look c;
  const float course = std::max(p.material.scale_m, 0.01F);
  const float length = 3.0F * course;
  const float mortar = std::clamp(0.16F * course, 0.004F, 0.03F);
  const F row = Floor(p.v * F(1.0F / course));
  const F odd = row - F(2.0F) * Floor(F(0.5F) * row);
  const F shifted = p.u + odd * F(0.5F * length);
  const U hash = HashOf(BitsOf(Floor(shifted * F(1.0F / length))), BitsOf(row), U(p.seed));
  // Every brick was burnt for itself: tone and a little hue; a few are much darker.
  const F brick_seen = Seen(p, course);
  const F tone = UnitOf(hash) - F(0.5F);
  const F hue = F(p.contrast) * brick_seen * (UnitOf(hash * U(0x9E3779B1U)) - F(0.5F));
  const F burnt = Select(UnitOf(hash * U(0x85EBCA77U)) > F(0.9F), F(-0.35F), F(0.035F));
  const F face = Fractal(p.u, p.v, 0.5F * course, 3, 0.7F, p.per_width, U(p.seed) + hash);
  const F change = brick_seen * (F(0.55F) * tone + burnt) + F(0.12F) * face;
  Rgb brick = p.base * (F(1.0F) + F(p.contrast) * change);
  brick.g *= F(1.0F) + F(0.22F) * hue;
  brick.b *= F(1.0F) + F(0.30F) * hue;
  const F joint = EitherJoint(JointShare(p.v, p.width_v, course, mortar),
                              JointShare(shifted, p.width_u, length, mortar));
  const Rgb filling = p.second * (F(1.0F) + F(0.15F) * FractalAt(p, 0.05F, 2, 0.6F, 71U));
  c.rgb = Blend(brick, filling, joint * F(std::min(1.0F, p.contrast))) *
          (F(1.0F) + F(p.contrast) *
                         (F(0.10F) * Weather(p, 2.5F, 3) + F(0.05F) * Streaks(p, 0.3F, 3.0F, 43U)));
  c.slope_v = brick_seen * F(0.12F) * face;
  c.gloss = p.material.gloss;
  return c;
}

HWY_INLINE Look TilesLook(const PatternPlace& p) {
  Look c;
  const float side = std::max(p.material.scale_m, 0.01F);
  const float gap = std::clamp(0.04F * side, 0.002F, 0.012F);
  const U hash =
      HashOf(BitsOf(Floor(p.u * F(1.0F / side))), BitsOf(Floor(p.v * F(1.0F / side))), U(p.seed));
  const F seen = Seen(p, side);
  const F speckle = FractalAt(p, 0.1F * side, 2, 0.7F, 5U);
  const Rgb tile =
      p.base * (F(1.0F) + F(p.contrast) * (F(0.14F) * seen * (UnitOf(hash) - F(0.5F)) +
                                           F(0.05F) * speckle + F(0.05F) * Weather(p, 2.0F, 3)));
  const F joint =
      EitherJoint(JointShare(p.u, p.width_u, side, gap), JointShare(p.v, p.width_v, side, gap));
  c.rgb = Blend(tile, p.second, joint * F(std::min(1.0F, p.contrast)));
  // Each lies a little askew, which shows where tiles shine.
  c.slope_u = F(0.02F) * seen * (UnitOf(hash * U(0x9E3779B1U)) - F(0.5F));
  c.slope_v = F(0.02F) * seen * (UnitOf(hash * U(0x85EBCA77U)) - F(0.5F));
  c.gloss = p.material.gloss;
  return c;
}

HWY_INLINE Look CorrugatedLook(const PatternPlace& p) {
  Look c;
  const float wave = std::max(p.material.scale_m, 0.01F);
  const F turns = p.u * F(1.0F / wave);
  const F seen = DetailLeft(F(wave) * p.per_width_u);
  c.slope_u = F(0.75F * p.contrast) * seen * SinOfTurns(turns + F(0.25F));
  // Valleys keep dirt; overlapping sheets leave a dark line; rust runs down from the screws.
  const F valley = seen * F(0.10F) * SinOfTurns(turns);
  const F rust_place = Fractal(p.u, F(0.25F) * p.v, 0.8F, 4, 0.6F, p.per_width, U(p.seed + 23U));
  const F rust = F(0.75F * p.contrast) * SmoothStep(0.50F, 1.05F, rust_place);
  const F tone = valley + F(0.05F) * Weather(p, 2.2F, 3) + F(0.05F) * Streaks(p, 0.12F, 1.8F, 47U);
  c.rgb = Blend(p.base * (F(1.0F) + F(p.contrast) * tone), Rgb{0.24F, 0.10F, 0.045F}, rust);
  const F lap = JointShare(p.u, p.width_u, 10.0F * wave, 0.012F);
  c.rgb = c.rgb * (F(1.0F) - F(0.55F * std::min(1.0F, p.contrast)) * lap);
  c.gloss = F(p.material.gloss) * (F(1.0F) - rust);
  return c;
}

HWY_INLINE Look GlassLook(const PatternPlace& p) {
  Look c;
  const float pane = std::max(p.material.scale_m, 0.1F);
  const U hash = HashOf(BitsOf(Floor(p.u * F(1.0F / pane))), U(0U), U(p.seed));
  // Rooms are dark; behind some panes hangs a curtain, in folds.
  const F bend = F(0.4F) * Noise(p.v * F(1.0F / 0.8F), F(0.0F), U(p.seed));
  const F folds = DetailLeft(F(0.07F) * p.per_width_u) *
                  Noise(p.u * F(1.0F / 0.07F) + bend, F(0.0F), U(p.seed + 3U));
  const Is curtain = UnitOf(hash) < F(0.35F * p.contrast);
  const Rgb room = p.base * (F(0.55F) + F(0.20F) * FractalAt(p, 0.9F, 2, 0.5F, 7U));
  c.rgb = Select(curtain, Blend(room, p.second * (F(0.5F) + F(0.10F) * folds), 0.6F), room);
  // Panes are never quite flat nor quite parallel.
  c.slope_u = F(0.012F) * (UnitOf(hash * U(0x9E3779B1U)) - F(0.5F)) +
              F(0.002F) * NoiseAt(p, 0.5F, 0.5F, 11U);
  c.slope_v = F(0.012F) * (UnitOf(hash * U(0x85EBCA77U)) - F(0.5F)) +
              F(0.002F) * NoiseAt(p, 0.5F, 0.5F, 13U);
  c.gloss = std::max(p.material.gloss, 0.06F);
  return c;
}

HWY_INLINE Look WoodLook(const PatternPlace& p) {
  Look c;
  const float board = std::max(p.material.scale_m, 0.01F);
  const U hash = HashOf(BitsOf(Floor(p.v * F(1.0F / board))), U(0U), U(p.seed));
  const F seen = DetailLeft(F(board) * p.per_width_v);
  // Grain: rings cut lengthwise, drawn out along the board and bent by a slow noise.
  const F bend = Fractal(p.u * F(0.3F), p.v, 0.5F, 2, 0.5F, p.per_width, hash);
  const F across = p.v * F(1.0F / 0.018F) + F(2.5F) * bend;
  const F grain =
      DetailLeft(F(0.02F) * p.per_width_v) * Noise(p.u * F(1.0F / 0.9F), across, hash + U(1U));
  const F fine = DetailLeft(F(0.006F) * p.per_width_v) *
                 Noise(p.u * F(1.0F / 0.25F), p.v * F(1.0F / 0.004F), hash + U(2U));
  const F tone = F(0.30F) * seen * (UnitOf(hash) - F(0.5F)) + F(0.16F) * grain + F(0.08F) * fine +
                 F(0.08F) * Weather(p, 1.4F, 3);
  const F joint = JointShare(p.v, p.width_v, board, std::min(0.006F, 0.1F * board));
  c.rgb = Blend(p.base * (F(1.0F) + F(p.contrast) * tone), p.second * 0.5F,
                joint * F(std::min(1.0F, p.contrast)));
  c.gloss = p.material.gloss;
  return c;
}

}  // namespace kawara::sim::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
