#include "sim/render/pattern_tools.hpp"

/// What lies on the ground or grows from it, and clothes.
namespace kawara::sim {
namespace {

/// Thin dark lines along the zeros of a bent noise; `width_m` wide, averaged over the footprint.
float Cracks(const PatternPlace& p, float wavelength_m, float width_m, std::uint32_t salt) {
  const float blur_m = std::max(p.width, 0.3F * width_m);
  const float share = std::min(1.0F, width_m / blur_m);
  if (share < 0.03F) return 0.0F;
  // Not everywhere: whole parts of a road are sound.
  const float where = SmoothStep(0.1F, 0.5F, Noise2(p.u / 7.0F, p.v / 7.0F, p.seed + salt + 3U));
  if (where <= 0.0F) return 0.0F;
  const float bend_u = 0.35F * Noise2(p.u / 0.4F, p.v / 0.4F, p.seed + salt + 1U);
  const float bend_v = 0.35F * Noise2(p.u / 0.4F, p.v / 0.4F, p.seed + salt + 2U);
  const float value =
      Noise2((p.u + bend_u) / wavelength_m, (p.v + bend_v) / wavelength_m, p.seed + salt);
  // The noise crosses zero with a slope of about 1.5 a wavelength.
  const float distance_m = std::abs(value) * wavelength_m / 1.5F;
  return where * share * (1.0F - SmoothStep(0.5F * width_m, 0.5F * width_m + blur_m, distance_m));
}

}  // namespace

SurfaceColour AsphaltColour(const PatternPlace& p) {
  SurfaceColour c;
  // Stones of 8 to 12 mm in dark binder, worn light where wheels run; tone changes over metres.
  float tone = 0.055F * Fractal2(p.u, p.v, 3.6F, 8, 1.03F, p.width, p.seed + 1U);
  Eigen::Array3f colour = p.base;
  const float stones = DetailLeft(0.012F, p.width);
  if (stones > 0.0F) {
    const NearestCells stone = FindCells(p.u / 0.011F, p.v / 0.011F, p.seed + 3U);
    const float light = UnitFromHash(stone.hash * 0x9E3779B1U);
    colour = Blend(colour, p.second,
                   0.6F * p.contrast * stones * (SmoothStep(0.5F, 1.0F, light) - 0.25F));
    tone +=
        stones * (0.25F * (light - 0.5F) + 0.30F * (0.5F - SmoothStep(0.2F, 0.7F, stone.first)));
  }
  // A mended rectangle here and there, of newer, darker stuff.
  const float cell_m = 6.5F;
  const std::int32_t i = FloorInt(p.u / cell_m);
  const std::int32_t j = FloorInt(p.v / cell_m);
  const std::uint32_t hash = HashCell(i, j, p.seed + 4U);
  if (UnitFromHash(hash) < 0.22F) {
    const float half_u = 0.4F + 1.5F * UnitFromHash(hash * 0x9E3779B1U);
    const float half_v = 0.4F + 0.9F * UnitFromHash(hash * 0x85EBCA77U);
    const float du = std::abs(p.u - (static_cast<float>(i) + 0.5F) * cell_m) - half_u;
    const float dv = std::abs(p.v - (static_cast<float>(j) + 0.5F) * cell_m) - half_v;
    const float edge = std::max(du, dv) + 0.02F * Noise2(p.u / 0.1F, p.v / 0.1F, p.seed + 5U);
    const float blur = std::max(0.01F, 0.5F * p.width);
    tone -= 0.26F * (1.0F - SmoothStep(-blur, blur, edge));
    tone -= 0.30F * (1.0F - SmoothStep(0.02F, 0.02F + blur, std::abs(edge))) *
            std::min(1.0F, 0.04F / (0.04F + blur));
  }
  // Oil where something stood: the high end of a slow noise, ragged by the tone itself.
  const float oil = DetailLeft(1.3F, p.width) * Noise2(p.u / 1.3F, p.v / 1.3F, p.seed + 6U);
  tone -= 0.35F * SmoothStep(0.55F, 1.0F, oil + 2.0F * tone);
  c.rgb = colour * (1.0F + p.contrast * tone);
  c.rgb *= 1.0F - 0.65F * std::min(1.0F, p.contrast) * Cracks(p, 2.6F, 0.010F, 60U);
  c.gloss = p.material.gloss;
  return c;
}

SurfaceColour SoilColour(const PatternPlace& p) {
  SurfaceColour c;
  const float broad = Fractal2(p.u, p.v, 2.6F, 3, 0.6F, p.width, p.seed + 1U);
  const float crumbs = 0.85F * Fractal2(p.u, p.v, 0.6F, 7, 1.0F, p.width, p.seed + 2U);
  Eigen::Array3f colour = Blend(p.base, p.second, SmoothStep(-0.3F, 0.9F, broad));
  float tone = 0.17F * crumbs;
  const float size_m = std::clamp(0.5F * p.material.scale_m, 0.01F, 0.10F);
  const float pebbles = DetailLeft(size_m, p.width);
  if (pebbles > 0.0F) {
    const NearestCells pebble = FindCells(p.u / size_m, p.v / size_m, p.seed + 3U);
    const float kind = UnitFromHash(pebble.hash * 0x9E3779B1U);
    const float inside = 1.0F - SmoothStep(0.30F, 0.42F, pebble.first);
    tone += pebbles * inside * (0.9F * kind - 0.35F) - pebbles * 0.12F;
    c.slope_u = 0.35F * pebbles * inside * (UnitFromHash(pebble.hash * 0x85EBCA77U) - 0.5F);
  }
  c.rgb = colour * (1.0F + p.contrast * tone);
  c.gloss = p.material.gloss;
  return c;
}

SurfaceColour GrassColour(const PatternPlace& p) {
  SurfaceColour c;
  const float broad = Fractal2(p.u, p.v, 1.8F, 3, 0.6F, p.width, p.seed + 1U);
  const float tufts = Fractal2(p.u, p.v, 0.22F, 3, 0.75F, p.width, p.seed + 2U);
  // Blades: thin and of any direction; two crossed sets of drawn-out noise.
  const float seen = DetailLeft(0.015F, p.width);
  float blades = 0.0F;
  if (seen > 0.0F) {
    const float a = Noise2((p.u + 0.6F * p.v) / 0.010F, (p.v - 0.6F * p.u) / 0.07F, p.seed + 3U);
    const float b = Noise2((p.u - 0.8F * p.v) / 0.010F, (p.v + 0.8F * p.u) / 0.07F, p.seed + 4U);
    blades = seen * (std::max(a, b) - 0.22F);  // less its mean
  }
  c.rgb = Blend(p.base, p.second, SmoothStep(-1.1F, 1.1F, broad + 0.5F * tufts));
  c.rgb *= 1.0F + p.contrast * (0.30F * tufts + 0.45F * blades);
  c.slope_u = 0.30F * tufts;
  c.slope_v = 0.30F * blades;
  c.luminance = 0.15F;
  c.gloss = p.material.gloss;
  return c;
}

SurfaceColour LeavesColour(const PatternPlace& p) {
  SurfaceColour c;
  const float leaf_m = std::clamp(p.material.scale_m, 0.03F, 0.3F);
  const float clumps = Fractal2(p.u, p.v, 0.9F, 3, 0.65F, p.width, p.seed + 1U);
  const float seen = DetailLeft(leaf_m, p.width);
  // What leaves and gaps come to when they cannot be told apart any more.
  float tone = 0.45F * clumps - 0.19F * (1.0F - seen);
  float share_of_second = 0.35F * (1.0F - seen);
  if (seen > 0.0F) {
    // Two layers: leaves in front, and in the gaps between them darkness and leaves behind.
    const NearestCells front = FindCells(p.u / leaf_m, p.v / leaf_m, p.seed + 2U);
    const float kind = UnitFromHash(front.hash * 0x9E3779B1U);
    const float gap = SmoothStep(0.36F, 0.60F, front.first);
    const float behind = Noise2(p.u / (0.6F * leaf_m), p.v / (0.6F * leaf_m), p.seed + 3U);
    share_of_second += seen * 0.7F * kind;
    tone += seen * (Mix(0.6F * (kind - 0.45F), -0.62F + 0.15F * behind, gap));
    c.slope_u = seen * 1.1F * (UnitFromHash(front.hash * 0x85EBCA77U) - 0.5F);
    c.slope_v = seen * 1.1F * (UnitFromHash(front.hash * 0xC2B2AE3DU) - 0.5F);
  }
  c.rgb = Blend(p.base, p.second, share_of_second) *
          std::max(0.08F, 1.0F + p.contrast * (tone - 0.12F));
  c.luminance = 0.35F;
  c.gloss = p.material.gloss;
  return c;
}

SurfaceColour RubbleColour(const PatternPlace& p) {
  SurfaceColour c;
  const float chunk_m = std::clamp(p.material.scale_m, 0.05F, 2.0F);
  // Lumps in two sizes, the smaller filling the gaps of the larger.
  NearestCells lump = FindCells(p.u / chunk_m, p.v / chunk_m, p.seed + 1U);
  float size_m = chunk_m;
  if (lump.second - lump.first < 0.16F) {
    lump = FindCells(p.u / (0.3F * chunk_m), p.v / (0.3F * chunk_m), p.seed + 2U);
    size_m = 0.3F * chunk_m;
  }
  const float seen = DetailLeft(size_m, p.width);
  const float kind = UnitFromHash(lump.hash * 0x9E3779B1U);
  const float tone = UnitFromHash(lump.hash * 0x85EBCA77U) - 0.5F;
  // Mostly the base (broken concrete), some of the second tone, some brick, plaster and wood.
  Eigen::Array3f colour = p.base;
  if (kind > 0.60F) colour = p.second;
  if (kind > 0.80F) colour = Eigen::Array3f(0.36F, 0.15F, 0.09F);
  if (kind > 0.88F) colour = Eigen::Array3f(0.62F, 0.60F, 0.55F);
  if (kind > 0.95F) colour = Eigen::Array3f(0.28F, 0.19F, 0.11F);
  colour = Blend(Blend(p.base, p.second, 0.3F), colour, seen * std::min(1.0F, p.contrast));
  const float dust = Fractal2(p.u, p.v, 0.25F * chunk_m, 4, 0.75F, p.width, p.seed + 3U);
  const float gap = seen * (1.0F - SmoothStep(0.0F, 0.22F, lump.second - lump.first));
  c.rgb = colour * (1.0F + p.contrast * (0.5F * seen * tone + 0.18F * dust)) *
          (1.0F - 0.75F * gap * std::min(1.0F, p.contrast));
  c.slope_u = seen * 1.0F * (UnitFromHash(lump.hash * 0xC2B2AE3DU) - 0.5F) + 0.2F * dust;
  c.slope_v = seen * 1.0F * (UnitFromHash(lump.hash * 0x27D4EB2FU) - 0.5F);
  c.gloss = p.material.gloss;
  return c;
}

SurfaceColour ClothColour(const PatternPlace& p) {
  SurfaceColour c;
  const float folds = DetailLeft(0.08F, p.width) *
                      Noise2(p.u / 0.09F + 0.8F * Noise2(p.u / 0.3F, p.v / 0.25F, p.seed),
                             p.v / 0.35F, p.seed + 1U);
  const float weave = Fractal2(p.u, p.v, 0.03F, 3, 0.7F, p.width, p.seed + 2U);
  const float patch = DetailLeft(0.35F, p.width) * Noise2(p.u / 0.5F, p.v / 0.3F, p.seed + 3U);
  c.rgb = Blend(p.base, p.second, 0.5F * SmoothStep(0.35F, 0.5F, patch));
  c.rgb *= 1.0F + p.contrast * (0.16F * folds + 0.08F * weave);
  c.slope_u = 0.45F * folds;
  c.gloss = p.material.gloss;
  return c;
}

}  // namespace kawara::sim
