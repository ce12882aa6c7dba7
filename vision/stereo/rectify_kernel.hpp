#pragma once
#include <cstddef>
#include <cstdint>

#include "vision/camera/radial_projection.hpp"

/// The inner loops of rectification, compiled for every SIMD target (Highway).
namespace kawara::vision::rectify {

/// Directions of a meridian: cosine[x] * pole + sine[x] * side, both in the optical frame.
struct Meridian {
  float pole[3];
  float side[3];
};

/// Where the pixels of a meridian are in the source picture [px]; NaN where they are not.
void ProjectRow(const RadialTable& table, const Meridian& meridian, const float* cosine,
                const float* sine, std::size_t count, float* u_px, float* v_px);

/// Bilinear samples of a packed picture (rectified_picture.hpp) at u, v; 0 outside, at NaN, and
/// where any of the four is not seen.
void SampleRow(const std::uint32_t* source, int width_px, int height_px, const float* u_px,
               const float* v_px, std::size_t count, std::uint32_t* target);

}  // namespace kawara::vision::rectify
