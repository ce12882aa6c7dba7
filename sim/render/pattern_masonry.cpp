#include "sim/render/pattern_tools.hpp"

/// Walls and what is laid in courses: concrete, brick, tiles, sheet metal, glass, boards, paint.
namespace kawara::sim {
namespace {

const Eigen::Array3f kRust(0.24F, 0.10F, 0.045F);

/// Rain runs down a wall: streaks narrow in u, long in v.
float Streaks(const PatternPlace& p, float width_m, float length_m, std::uint32_t salt) {
  return DetailLeft(width_m, p.width_u) * Noise2(p.u / width_m, p.v / length_m, p.seed + salt);
}

/// Slow change of shade no real wall is without.
float Weather(const PatternPlace& p, float wavelength_m, int octaves) {
  return Fractal2(p.u, p.v, wavelength_m, octaves, 0.5F, p.width, p.seed + 17U);
}

}  // namespace

SurfaceColour PlainColour(const PatternPlace& p) {
  SurfaceColour c;
  c.rgb = p.base * (1.0F + 0.012F * p.contrast * Weather(p, 3.0F, 2));
  c.gloss = p.material.gloss;
  return c;
}

SurfaceColour ConcreteColour(const PatternPlace& p) {
  SurfaceColour c;
  // Blotches of metres down to grains of a centimetre; streaks; stains at the dark end of a noise.
  const float grain = Fractal2(p.u, p.v, 1.7F, 8, 0.95F, p.width, p.seed + 31U);
  const float blotch = DetailLeft(1.1F, p.width) * Noise2(p.u / 1.1F, p.v / 1.1F, p.seed + 53U);
  float tone = 0.055F * grain + 0.05F * blotch + 0.06F * Streaks(p, 0.22F, 2.4F, 41U);
  tone -= 0.18F * SmoothStep(0.40F, 0.95F, blotch + 0.15F * grain);
  const float pores = DetailLeft(0.02F, p.width);
  if (pores > 0.0F) {
    tone -=
        0.25F * pores * SmoothStep(0.62F, 0.75F, Noise2(p.u / 0.02F, p.v / 0.02F, p.seed + 59U));
  }
  c.rgb = p.base * (1.0F + p.contrast * tone);
  c.rgb *= Eigen::Array3f(1.0F, 1.0F, 1.0F) +
           p.contrast * 0.03F * blotch * Eigen::Array3f(1.0F, 0.2F, -1.0F);
  if (p.material.scale_m > 0.05F) {
    const float joint = EitherJoint(JointShare(p.u, p.width_u, 2.0F * p.material.scale_m, 0.012F),
                                    JointShare(p.v, p.width_v, p.material.scale_m, 0.012F));
    c.rgb = Blend(c.rgb, p.second * 0.7F, std::min(1.0F, p.contrast) * joint);
  }
  c.slope_u = 0.05F * p.contrast * grain;
  c.gloss = p.material.gloss;
  return c;
}

SurfaceColour BrickColour(const PatternPlace& p) {
  SurfaceColour c;
  const float course = std::max(p.material.scale_m, 0.01F);
  const float length = 3.0F * course;
  const float mortar = std::clamp(0.16F * course, 0.004F, 0.03F);
  const std::int32_t row = FloorInt(p.v / course);
  const float shifted = p.u + ((row & 1) != 0 ? 0.5F * length : 0.0F);
  const std::int32_t column = FloorInt(shifted / length);
  const std::uint32_t hash = HashCell(column, row, p.seed);
  // Every brick was burnt for itself: tone and a little hue; a few are much darker.
  const float brick_seen = DetailLeft(course, p.width);
  const float tone = UnitFromHash(hash) - 0.5F;
  const float hue = UnitFromHash(hash * 0x9E3779B1U) - 0.5F;
  const float burnt = UnitFromHash(hash * 0x85EBCA77U) > 0.9F ? -0.35F : 0.035F;
  const float face = Fractal2(p.u, p.v, 0.5F * course, 3, 0.7F, p.width, p.seed + hash);
  const float change = brick_seen * (0.55F * tone + burnt) + 0.12F * face;
  Eigen::Array3f brick = p.base * (1.0F + p.contrast * change);
  brick *= Eigen::Array3f(1.0F, 1.0F + 0.22F * p.contrast * brick_seen * hue,
                          1.0F + 0.30F * p.contrast * brick_seen * hue);
  const float joint = EitherJoint(JointShare(p.v, p.width_v, course, mortar),
                                  JointShare(shifted, p.width_u, length, mortar));
  const Eigen::Array3f filling =
      p.second * (1.0F + 0.15F * Fractal2(p.u, p.v, 0.05F, 2, 0.6F, p.width, p.seed + 71U));
  c.rgb = Blend(brick, filling, joint * std::min(1.0F, p.contrast));
  c.rgb *= 1.0F + p.contrast * (0.10F * Weather(p, 2.5F, 3) + 0.05F * Streaks(p, 0.3F, 3.0F, 43U));
  c.slope_v = brick_seen * 0.12F * face;
  c.gloss = p.material.gloss;
  return c;
}

SurfaceColour TilesColour(const PatternPlace& p) {
  SurfaceColour c;
  const float side = std::max(p.material.scale_m, 0.01F);
  const float gap = std::clamp(0.04F * side, 0.002F, 0.012F);
  const std::uint32_t hash = HashCell(FloorInt(p.u / side), FloorInt(p.v / side), p.seed);
  const float seen = DetailLeft(side, p.width);
  const float speckle = Fractal2(p.u, p.v, 0.1F * side, 2, 0.7F, p.width, p.seed + 5U);
  const Eigen::Array3f tile =
      p.base * (1.0F + p.contrast * (0.14F * seen * (UnitFromHash(hash) - 0.5F) + 0.05F * speckle +
                                     0.05F * Weather(p, 2.0F, 3)));
  const float joint =
      EitherJoint(JointShare(p.u, p.width_u, side, gap), JointShare(p.v, p.width_v, side, gap));
  c.rgb = Blend(tile, p.second, joint * std::min(1.0F, p.contrast));
  // Each lies a little askew, which shows where tiles shine.
  c.slope_u = 0.02F * seen * (UnitFromHash(hash * 0x9E3779B1U) - 0.5F);
  c.slope_v = 0.02F * seen * (UnitFromHash(hash * 0x85EBCA77U) - 0.5F);
  c.gloss = p.material.gloss;
  return c;
}

SurfaceColour CorrugatedColour(const PatternPlace& p) {
  SurfaceColour c;
  const float wave = std::max(p.material.scale_m, 0.01F);
  const float phase = p.u / wave - static_cast<float>(FloorInt(p.u / wave));
  const float seen = DetailLeft(wave, p.width_u);
  const float angle = 6.2831853F * phase;
  c.slope_u = 0.75F * p.contrast * seen * std::cos(angle);
  // Valleys keep dirt; overlapping sheets leave a dark line; rust runs down from the screws.
  const float valley = seen * 0.10F * std::sin(angle);
  const float rust_place = Fractal2(p.u, 0.25F * p.v, 0.8F, 4, 0.6F, p.width, p.seed + 23U);
  const float rust = 0.75F * p.contrast * SmoothStep(0.50F, 1.05F, rust_place);
  const float tone = valley + 0.05F * Weather(p, 2.2F, 3) + 0.05F * Streaks(p, 0.12F, 1.8F, 47U);
  c.rgb = Blend(p.base * (1.0F + p.contrast * tone), kRust, rust);
  const float lap = JointShare(p.u, p.width_u, 10.0F * wave, 0.012F);
  c.rgb *= 1.0F - 0.55F * lap * std::min(1.0F, p.contrast);
  c.gloss = p.material.gloss * (1.0F - rust);
  return c;
}

SurfaceColour GlassColour(const PatternPlace& p) {
  SurfaceColour c;
  const float pane = std::max(p.material.scale_m, 0.1F);
  const std::int32_t column = FloorInt(p.u / pane);
  const std::uint32_t hash = HashCell(column, 0, p.seed);
  // Rooms are dark; behind some panes hangs a curtain, in folds.
  const float folds =
      DetailLeft(0.07F, p.width_u) *
      Noise2(p.u / 0.07F + 0.4F * Noise2(p.v / 0.8F, 0.0F, p.seed), 0.0F, p.seed + 3U);
  const bool curtain = UnitFromHash(hash) < 0.35F * p.contrast;
  const Eigen::Array3f room =
      p.base * (0.55F + 0.20F * Fractal2(p.u, p.v, 0.9F, 2, 0.5F, p.width, p.seed + 7U));
  c.rgb = curtain ? Blend(room, p.second * (0.5F + 0.10F * folds), 0.6F) : room;
  // Panes are never quite flat nor quite parallel.
  c.slope_u = 0.012F * (UnitFromHash(hash * 0x9E3779B1U) - 0.5F) +
              0.002F * Noise2(p.u / 0.5F, p.v / 0.5F, p.seed + 11U);
  c.slope_v = 0.012F * (UnitFromHash(hash * 0x85EBCA77U) - 0.5F) +
              0.002F * Noise2(p.u / 0.5F, p.v / 0.5F, p.seed + 13U);
  c.gloss = std::max(p.material.gloss, 0.06F);
  return c;
}

SurfaceColour WoodColour(const PatternPlace& p) {
  SurfaceColour c;
  const float board = std::max(p.material.scale_m, 0.01F);
  const std::int32_t number = FloorInt(p.v / board);
  const std::uint32_t hash = HashCell(number, 0, p.seed);
  const float seen = DetailLeft(board, p.width_v);
  // Grain: rings cut lengthwise, drawn out along the board and bent by a slow noise.
  const float bend = Fractal2(p.u * 0.3F, p.v, 0.5F, 2, 0.5F, p.width, hash);
  const float across = p.v / 0.018F + 2.5F * bend;
  const float grain = DetailLeft(0.02F, p.width_v) * Noise2(p.u / 0.9F, across, hash + 1U);
  const float fine = DetailLeft(0.006F, p.width_v) * Noise2(p.u / 0.25F, p.v / 0.004F, hash + 2U);
  const float tone = 0.30F * seen * (UnitFromHash(hash) - 0.5F) + 0.16F * grain + 0.08F * fine +
                     0.08F * Weather(p, 1.4F, 3);
  c.rgb = p.base * (1.0F + p.contrast * tone);
  const float joint = JointShare(p.v, p.width_v, board, std::min(0.006F, 0.1F * board));
  c.rgb = Blend(c.rgb, p.second * 0.5F, joint * std::min(1.0F, p.contrast));
  c.gloss = p.material.gloss;
  return c;
}

}  // namespace kawara::sim
