#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/config/constraints.hpp"
#include "vision/camera/camera_model.hpp"

namespace kawara::sim {

/// What glass, mirror and dirt do to the picture.
struct LensSettings {
  double vignetting = 0.35;  ///< light lost at the rim of the picture (or ring), 0..1
  int dirt_spots = 6;        ///< on the mirror; out of focus, so they only dim and veil
  double dirt_size = 0.012;  ///< radius of the largest, share of the picture's width
  double surround = 0.02;  ///< brightness of what is seen beside the ring: the camera in its mirror
  std::uint32_t seed = 1;  ///< where the dirt sits

  template <class V>
  void Visit(V& v) {
    using core::config::Optional;
    using core::config::Range;
    v("vignetting", vignetting, Range{0, 0.95}, Optional{});
    v("dirt_spots", dirt_spots, Range{0, 1000}, Optional{});
    v("dirt_size", dirt_size, Range{0.0001, 0.2}, Optional{});
    v("surround", surround, Range{0, 0.5}, Optional{});
    v("seed", seed, Optional{});
  }
};

/// One pixel that sees the world.
struct PixelRay {
  Eigen::Vector3d direction_camera;  ///< unit, through the pixel's centre
  float pixel_rad = 0.0F;            ///< angle to the neighbours, geometric mean of both axes
  float through = 1.0F;              ///< light that passes lens and dirt
  float veil = 0.0F;  ///< share of the surroundings' mean light that dirt scatters in
  std::uint16_t u = 0, v = 0;
};

/// How a pixel's ray changes from its left edge to its right one and from its upper to its lower.
struct PixelTangents {
  Eigen::Vector3f along_u, along_v;

  /// Pixels between this pixel and the one that sees a direction `off` this one's ray; for a few
  /// pixels.
  Eigen::Vector2f PixelsTo(const Eigen::Vector3f& off) const {
    const float a = along_u.squaredNorm();
    const float b = along_u.dot(along_v);
    const float c = along_v.squaredNorm();
    const float u = along_u.dot(off);
    const float v = along_v.dot(off);
    return Eigen::Vector2f(u * c - v * b, v * a - u * b) / (a * c - b * b);
  }
};

/// One pixel beside the field of view, and how bright it is (linear, 1: white).
struct SurroundPixel {
  std::uint32_t index = 0;
  float value = 0.0F;
};

/// All rays of a camera, computed once for all its frames. Pixels outside the field of view have
/// none. Immutable; any thread.
struct RayTable {
  /// Tile after tile (32 x 32), in it 4 x 4 block after block, so that sixteen rays in a row are
  /// neighbours.
  std::vector<PixelRay> rays;
  std::vector<PixelTangents> tangents;  ///< of each ray
  std::vector<SurroundPixel> surround;
  int width_px = 0;
  /// Place in `rays` of pixel v * width + u, or -1.
  std::vector<std::int32_t> ray_at;

  std::int32_t RayAt(int u, int v) const {
    return ray_at[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_px) +
                  static_cast<std::size_t>(u)];
  }

  static RayTable Build(const vision::CameraModel& camera, const LensSettings& lens);
};

}  // namespace kawara::sim
