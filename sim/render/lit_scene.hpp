#pragma once
#include <memory>

#include "core/expected.hpp"
#include "sim/render/light_field.hpp"
#include "sim/render/ray_scene.hpp"
#include "sim/render/sky_map.hpp"

namespace kawara::sim {

/// One look at a surface.
struct SurfaceView {
  const Material& material;
  const RayHit& hit;              ///< normal and gradients in ENU
  Eigen::Vector3d place_enu_m;    ///< of the hit
  Eigen::Vector3f direction_enu;  ///< of the ray, away from the eye; unit
  float pixel_rad = 0.0F;         ///< angle between neighbouring pixels
  bool sunlit = false;            ///< no shadow falls here
  RayScene::Moment moment;
};

/// A scene with its light: what cameras look at. Made once a site (takes seconds), shared by all
/// cameras. Immutable; any thread.
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
  /// Light that leaves the surface towards the eye, haze on its way included (linear RGB; a white
  /// level surface in the open is 1). Glass casts one more ray for what it mirrors.
  Eigen::Array3f Radiance(const SurfaceView& view) const { return Shade(view, true); }

 private:
  LitScene(RayScene rays, const Eigen::AlignedBox3f& lit_region_enu_m, const LightSettings& light);
  Eigen::Array3f Shade(const SurfaceView& view, bool may_mirror) const;
  Eigen::Array3f Mirrored(const SurfaceView& view, const Eigen::Vector3f& direction) const;

  RayScene rays_;
  SkyMap sky_;
  LightField light_;
};

}  // namespace kawara::sim
