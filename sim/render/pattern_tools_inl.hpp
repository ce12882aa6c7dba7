#if defined(KAWARA_SIM_RENDER_PATTERN_TOOLS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef KAWARA_SIM_RENDER_PATTERN_TOOLS_INL
#undef KAWARA_SIM_RENDER_PATTERN_TOOLS_INL
#else
#define KAWARA_SIM_RENDER_PATTERN_TOOLS_INL
#endif

#include <algorithm>

#include "sim/render/lane_math_inl.hpp"
#include "sim/site/scene.hpp"

/// Inside of surface_pattern: what one pattern works with, for as many places as there are lanes.
HWY_BEFORE_NAMESPACE();
namespace kawara::sim::HWY_NAMESPACE {

// Constructors are written out where the compiler's own would lack the target's attributes.
struct Rgb {
  F r, g, b;
  HWY_INLINE Rgb() {}  // NOLINT
  HWY_INLINE Rgb(F red, F green, F blue) : r(red), g(green), b(blue) {}
};
HWY_INLINE Rgb operator+(const Rgb& a, const Rgb& b) { return {a.r + b.r, a.g + b.g, a.b + b.b}; }
HWY_INLINE Rgb operator*(const Rgb& a, F x) { return {a.r * x, a.g * x, a.b * x}; }
HWY_INLINE Rgb Blend(const Rgb& a, const Rgb& b, F share_of_b) {
  return {Mix(a.r, b.r, share_of_b), Mix(a.g, b.g, share_of_b), Mix(a.b, b.b, share_of_b)};
}
HWY_INLINE Rgb Select(Is yes, const Rgb& a, const Rgb& b) {
  return {Select(yes, a.r, b.r), Select(yes, a.g, b.g), Select(yes, a.b, b.b)};
}
HWY_INLINE Rgb RgbOf(const std::array<float, 3>& rgb) { return {F(rgb[0]), F(rgb[1]), F(rgb[2])}; }

struct PatternPlace {
  const Material& material;
  Rgb base, second;
  F u, v;              ///< [m]
  F width_u, width_v;  ///< footprint [m]
  F width;             ///< one number for noise: between the shorter and the longer
  /// One over each, for footprints that are not quite nothing.
  F per_width_u, per_width_v, per_width;
  std::uint32_t seed;
  float contrast;
};

/// See SurfaceColour.
struct Look {
  Rgb rgb;
  F slope_u, slope_v, gloss;
  float luminance = 0.0F;
  HWY_INLINE Look() {}  // NOLINT
};

HWY_NOINLINE inline F NoiseAt(const PatternPlace& p, float length_u, float length_v,
                              std::uint32_t salt) {
  return Noise(p.u * F(1.0F / length_u), p.v * F(1.0F / length_v), U(p.seed + salt));
}
HWY_INLINE F FractalAt(const PatternPlace& p, float wavelength, int octaves, float persistence,
                       std::uint32_t salt) {
  return Fractal(p.u, p.v, wavelength, octaves, persistence, p.per_width, U(p.seed + salt));
}
/// What the footprint leaves of a detail of this size.
HWY_INLINE F Seen(const PatternPlace& p, float detail_m) {
  return DetailLeft(F(detail_m) * p.per_width);
}

/// Share of [x - width / 2, x + width / 2] that lies in joints of `joint` metres repeated every
/// `period`: the exact box average of a grid of lines.
HWY_INLINE F JointsUpTo(F to, float period, float joint) {
  const F turns = Floor(to * F(1.0F / period));
  return turns * F(joint) + Min(Max(to - turns * F(period), 0.0F), joint);
}
HWY_INLINE F JointShare(F x, F width, float period, float joint) {
  const F w = Max(width, 1e-4F);
  const F middle = x + F(joint / 2);
  const F half = F(0.5F) * w;
  const F covered =
      JointsUpTo(middle + half, period, joint) - JointsUpTo(middle - half, period, joint);
  return Min(Max(covered / w, 0.0F), 1.0F);
}
/// Either of two perpendicular sets of joints, for a footprint that meets them independently.
HWY_INLINE F EitherJoint(F a, F b) { return a + b - a * b; }

/// A scatter of cells (Worley): distance to the nearest and second nearest point, and the nearest
/// cell's hash.
struct NearestCells {
  F first, second;
  U hash;
};
HWY_NOINLINE inline NearestCells FindCells(F x, F y, U seed) {
  NearestCells found{F(9.0F), F(9.0F), U(0U)};
  const F i = Floor(x);
  const F j = Floor(y);
  const U middle = SumOfCell(BitsOf(i), BitsOf(j), seed);
  for (int dj = -1; dj <= 1; ++dj) {
    for (int di = -1; di <= 1; ++di) {
      const U hash = MixBits(middle + U(static_cast<std::uint32_t>(di) * 0x9E3779B1U +
                                        static_cast<std::uint32_t>(dj) * 0x85EBCA77U));
      const F px = i + F(static_cast<float>(di)) + FloatOf(hash & U(0xFFFFU)) * F(1.0F / 65536.0F);
      const F py = j + F(static_cast<float>(dj)) + FloatOf(Right<16>(hash)) * F(1.0F / 65536.0F);
      const F square = (px - x) * (px - x) + (py - y) * (py - y);
      const Is nearer = square < found.first;
      found.second = Select(nearer, found.first, Min(found.second, square));
      found.hash = Select(nearer, hash, found.hash);
      found.first = Min(found.first, square);
    }
  }
  found.first = Sqrt(found.first);
  found.second = Sqrt(found.second);
  return found;
}

}  // namespace kawara::sim::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
