#pragma once
#include <Eigen/Core>
#include <array>

#include "sim/site/scene.hpp"

namespace kawara::sim {

/// Where a surface is looked at, and how much of it one pixel takes in.
struct SurfacePoint {
  Eigen::Vector2f uv_m = Eigen::Vector2f::Zero();
  float footprint_u_m = 0.0F;  ///< extent of the pixel along u and v: grazing, one is much longer
  float footprint_v_m = 0.0F;
};

/// What is seen there.
struct SurfaceColour {
  Eigen::Array3f rgb = Eigen::Array3f::Zero();  ///< linear reflectance, 0..1
  /// Relief: how the surface rises along u and v (tangents of the slopes); averaged like the
  /// colour.
  float slope_u = 0.0F;
  float slope_v = 0.0F;
  float gloss = 0.0F;      ///< share that mirrors at normal incidence
  float luminance = 0.0F;  ///< share of light that comes through from behind (leaves)
};

/// Up to sixteen points at once, one array a quantity. All are finite, also those not asked for.
struct alignas(64) SurfacePoints {
  static constexpr std::size_t kMost = 16;
  std::array<float, kMost> u_m{}, v_m{}, footprint_u_m{}, footprint_v_m{};
};
struct alignas(64) SurfaceColours {
  std::array<float, SurfacePoints::kMost> red, green, blue, slope_u, slope_v, gloss;
  float luminance;  ///< the same of all
};

/// The material's pattern at the first `count` points, averaged over each pixel's footprint:
/// details smaller than it fade into their mean before they could alias, regular joints are
/// integrated exactly. u runs along the surface, v up it (walls). A pure function; the same colour
/// from every side and in every frame; the same bits in every lane and on every SIMD target. Any
/// thread. Colours beyond `count` are not defined.
void ColoursOf(const Material& material, const SurfacePoints& points, std::size_t count,
               SurfaceColours& colours);

/// The same of one point.
SurfaceColour ColourOf(const Material& material, const SurfacePoint& point);

}  // namespace kawara::sim
