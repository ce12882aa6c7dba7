#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "sim/render/noise2.hpp"
#include "sim/render/surface_pattern.hpp"

namespace kawara::sim {

/// Inside of surface_pattern: what one pattern works with.
struct PatternPlace {
  const Material& material;
  Eigen::Array3f base, second;
  float u, v;              ///< [m]
  float width_u, width_v;  ///< footprint [m]
  float width;             ///< one number for noise: between the shorter and the longer
  std::uint32_t seed;
  float contrast;
};

inline Eigen::Array3f RgbOf(const std::array<float, 3>& rgb) { return {rgb[0], rgb[1], rgb[2]}; }
inline Eigen::Array3f Blend(const Eigen::Array3f& a, const Eigen::Array3f& b, float share_of_b) {
  return a + (b - a) * share_of_b;
}

/// Share of [x - width / 2, x + width / 2] that lies in joints of `joint` metres repeated every
/// `period`: the exact box average of a grid of lines.
inline float JointShare(float x, float width, float period, float joint) {
  const auto covered = [&](float to) {
    const auto turns = static_cast<float>(FloorInt(to / period));
    return turns * joint + std::min(to - turns * period, joint);
  };
  const float w = std::max(width, 1e-4F);
  return std::clamp((covered(x + joint / 2 + w / 2) - covered(x + joint / 2 - w / 2)) / w, 0.0F,
                    1.0F);
}

/// Either of two perpendicular sets of joints, for a footprint that meets them independently.
inline float EitherJoint(float a, float b) { return a + b - a * b; }

/// A scatter of cells (Worley): distance to the nearest and second nearest point, and the nearest
/// cell's hash.
struct NearestCells {
  float first = 9.0F;
  float second = 9.0F;
  std::uint32_t hash = 0;
};
NearestCells FindCells(float x, float y, std::uint32_t seed);

// One a family; all in linear reflectance.
SurfaceColour PlainColour(const PatternPlace& p);
SurfaceColour AsphaltColour(const PatternPlace& p);
SurfaceColour ConcreteColour(const PatternPlace& p);
SurfaceColour BrickColour(const PatternPlace& p);
SurfaceColour TilesColour(const PatternPlace& p);
SurfaceColour CorrugatedColour(const PatternPlace& p);
SurfaceColour GlassColour(const PatternPlace& p);
SurfaceColour WoodColour(const PatternPlace& p);
SurfaceColour SoilColour(const PatternPlace& p);
SurfaceColour GrassColour(const PatternPlace& p);
SurfaceColour LeavesColour(const PatternPlace& p);
SurfaceColour RubbleColour(const PatternPlace& p);
SurfaceColour ClothColour(const PatternPlace& p);

}  // namespace kawara::sim
