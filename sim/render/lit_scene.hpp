#pragma once
#include <memory>
#include <span>

#include "core/expected.hpp"
#include "sim/render/light_field.hpp"
#include "sim/render/ray_scene.hpp"
#include "sim/render/sky_map.hpp"
#include "sim/render/surface_pattern.hpp"

namespace kawara::sim {

/// One look at a surface.
struct SurfaceView {
  const Material* material = nullptr;
  const RayHit* hit = nullptr;    ///< normal and gradients in ENU
  Eigen::Vector3d place_enu_m;    ///< of the hit
  Eigen::Vector3f direction_enu;  ///< of the ray, away from the eye; unit
  float pixel_rad = 0.0F;         ///< angle between neighbouring pixels
  bool sunlit = false;            ///< no shadow falls here
  RayScene::Moment moment;
};

/// A scene with its light: what cameras look at. Made once a site (takes seconds, or what
/// LightSettings::cache kept), shared by all cameras. Immutable; any thread.
class LitScene {
 public:
  /// Errors: RayScene::Create's.
  static core::Expected<std::shared_ptr<const LitScene>> Create(const Scene& scene,
                                                                const LightSettings& light = {});

  const RayScene& rays() const { return rays_; }
  const SkyMap& sky() const { return sky_; }
  const LightField& light() const { return light_; }

  /// Whether sunlight can matter at this hit: then, and only then, SurfaceView::sunlit is asked.
  /// `start`: where the shadow ray begins, a little off the surface.
  bool WantsSun(const Material& material, const RayHit& hit, const Eigen::Vector3d& place_enu_m,
                const Eigen::Vector3f& direction_enu, Eigen::Vector3d& start) const;
  /// What one thread remembers from look to look, to be quicker; it changes no result.
  struct Memory {
    LightField::Cell around, mirrored;
  };
  /// Light that leaves up to sixteen surfaces towards the eye, haze on its way included (linear
  /// RGB; a white level surface in the open is 1). Glass casts one more ray for what it mirrors.
  void Radiance(std::span<const SurfaceView> views, Memory& memory,
                std::span<Eigen::Array3f> light) const {
    Shade(views, true, memory, light);
  }

 private:
  LitScene(RayScene rays, const Eigen::AlignedBox3f& lit_region_enu_m, const LightSettings& light,
           std::uint64_t cache_key);
  void Shade(std::span<const SurfaceView> views, bool may_mirror, Memory& memory,
             std::span<Eigen::Array3f> light) const;
  Eigen::Array3f LightOf(const SurfaceView& view, const Eigen::Vector3f& normal, float cosine,
                         const SurfaceColour& colour, bool may_mirror, Memory& memory) const;
  Eigen::Array3f Mirrored(const SurfaceView& view, const Eigen::Vector3f& direction) const;

  RayScene rays_;
  SkyMap sky_;
  LightField light_;
};

}  // namespace kawara::sim
