#pragma once
#include <algorithm>
#include <cstdint>

namespace kawara::sim {

/// Noise over a plane for surfaces, clouds and dirt: a pure function of place and seed, the same
/// bits on every machine (32-bit integers and single floats in a fixed order). Any thread.

/// Well mixed bits of a lattice point. Source: the finalizer of MurmurHash3 (A. Appleby, public
/// domain) over a sum of odd multiples.
inline std::uint32_t HashCell(std::int32_t x, std::int32_t y, std::uint32_t seed) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x9E3779B1U +
                    static_cast<std::uint32_t>(y) * 0x85EBCA77U + seed * 0xC2B2AE3DU;
  h = (h ^ (h >> 16)) * 0x7FEB352DU;
  h = (h ^ (h >> 15)) * 0x846CA68BU;
  return h ^ (h >> 16);
}

/// Upper 24 bits to [0, 1).
inline float UnitFromHash(std::uint32_t hash) {
  return static_cast<float>(hash >> 8) * (1.0F / 16777216.0F);
}
inline float UnitAt(std::int32_t x, std::int32_t y, std::uint32_t seed) {
  return UnitFromHash(HashCell(x, y, seed));
}

/// floor() without a call into libm, for |x| < 2^31.
inline std::int32_t FloorInt(float x) {
  const auto i = static_cast<std::int32_t>(x);
  return i - static_cast<std::int32_t>(static_cast<float>(i) > x);
}

inline float SmoothStep(float low, float high, float x) {
  const float t = std::clamp((x - low) / (high - low), 0.0F, 1.0F);
  return t * t * (3.0F - 2.0F * t);
}
inline float Mix(float a, float b, float share_of_b) { return a + (b - a) * share_of_b; }

/// Value noise in [-1, 1], lattice spacing 1.
inline float Noise2(float x, float y, std::uint32_t seed) {
  const std::int32_t i = FloorInt(x);
  const std::int32_t j = FloorInt(y);
  const float fx = x - static_cast<float>(i);
  const float fy = y - static_cast<float>(j);
  const float sx = fx * fx * (3.0F - 2.0F * fx);
  const float sy = fy * fy * (3.0F - 2.0F * fy);
  const float low = Mix(UnitAt(i, j, seed), UnitAt(i + 1, j, seed), sx);
  const float high = Mix(UnitAt(i, j + 1, seed), UnitAt(i + 1, j + 1, seed), sx);
  return 2.0F * Mix(low, high, sy) - 1.0F;
}

/// How much of a detail of this size is left when it is averaged over a footprint: all of it when
/// it spans three footprints, nothing below one and a quarter (before it could alias).
inline float DetailLeft(float detail_m, float footprint_m) {
  return SmoothStep(1.25F, 3.0F, detail_m / std::max(footprint_m, 1e-6F));
}

/// Sum of up to eight octaves, about [-1, 1]: the coarsest has `wavelength_m`, each next half of it
/// and `persistence` times its strength. Octaves the footprint would average away are left out.
/// All octaves are computed at once (SIMD); the same bits on every target.
float Fractal2(float u_m, float v_m, float wavelength_m, int octaves, float persistence,
               float footprint_m, std::uint32_t seed);

}  // namespace kawara::sim
