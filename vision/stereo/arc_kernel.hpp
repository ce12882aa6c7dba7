#pragma once
#include <cstddef>

#include "vision/camera/radial_projection.hpp"

/// The inner loop of the epipolar curve, compiled for every SIMD target (Highway).
namespace kawara::vision::paper {

/// Rays start * cosine[i] + turn * sine[i] of the OPTICAL frame, and where a camera sees them.
struct Arc {
  float start[3];
  float turn[3];
  float up[3];  ///< a fixed direction
};
/// NaN where the camera does not see a ray. All arrays [count rounded up to 16].
struct ArcPixels {
  float* u_px;
  float* v_px;
  float* up_u;  ///< where the pixel moves when its ray turns towards `up`; any length
  float* up_v;
};
void ProjectArc(const RadialTable& table, const Arc& arc, const float* cosine, const float* sine,
                std::size_t count, const ArcPixels& out);

}  // namespace kawara::vision::paper
