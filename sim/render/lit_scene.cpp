#include "sim/render/lit_scene.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <set>

#include "core/check.hpp"
#include "sim/render/light_cache.hpp"

namespace kawara::sim {
namespace {

/// Off the surface, so that it does not shade itself.
constexpr double kShadowOffset_m = 0.001;
/// Ground beyond what stands on it that is still lit with care.
constexpr float kMargin_m = 6.0F;
/// Sine of the angle below which a surface is seen no more grazing than this.
constexpr float kMinGrazing = 0.02F;
/// Half of what is seen at this range is haze [m].
constexpr float kVisibility_m = 1800.0F;
/// Reflections weaker than this are not worth a ray.
constexpr float kLeastMirror = 0.01F;
/// Mirrored things are seen coarsely: a pane is never quite flat.
constexpr float kMirrorBlur_rad = 0.006F;

template <unsigned kExponent>
float Power(float x) {
  if constexpr (kExponent == 0) return 1.0F;
  const float half = Power<kExponent / 2>(x);
  return kExponent % 2 == 0 ? half * half : half * half * x;
}

bool LetsLightThrough(const Material& material) {
  return material.pattern == Pattern::kLeaves || material.pattern == Pattern::kGrass;
}

// The box round all that stands on the ground, and some ground about it: where the sky is hidden.
Eigen::AlignedBox3f BuiltPart(const Scene& scene) {
  std::set<std::uint32_t> ground;
  for (const SceneObject& object : scene.objects) {
    if (object.cls == ObjectClass::kGround || object.cls == ObjectClass::kKerb) {
      ground.insert(object.id);
    }
  }
  Eigen::AlignedBox3f box;
  for (const Mesh& mesh : scene.meshes) {
    if (ground.count(mesh.object) != 0) continue;
    for (const Eigen::Vector3f& v : mesh.vertices_m) box.extend(v);
  }
  if (box.isEmpty()) return box;
  const Eigen::Vector3f margin(kMargin_m, kMargin_m, 0.5F);
  return {box.min() - margin, box.max() + margin};
}

// Extent of the pixel's cone on the surface, along one of its uv axes: the cone's circle is
// projected along the ray onto the plane.
float Footprint(const Eigen::Vector3f& gradient, const Eigen::Vector3f& normal,
                const Eigen::Vector3f& direction, float along, float width_m) {
  return width_m * (gradient - normal * (gradient.dot(direction) / along)).norm();
}

}  // namespace

core::Expected<std::shared_ptr<const LitScene>> LitScene::Create(const Scene& scene,
                                                                 const LightSettings& light) {
  core::Expected<RayScene> rays = RayScene::Create(scene);
  if (!rays) return tl::unexpected(rays.error());
  return std::shared_ptr<const LitScene>(
      new LitScene(std::move(*rays), BuiltPart(scene), light, LightCache::KeyOf(scene, light)));
}

// The light is measured before anything comes, so with the things that always stand there.
LitScene::LitScene(RayScene rays, const Eigen::AlignedBox3f& lit_region_enu_m,
                   const LightSettings& light, std::uint64_t cache_key)
    : rays_(std::move(rays)),
      sky_(rays_.sun(), light.sky_seed, light.sky_columns),
      light_(rays_, sky_, lit_region_enu_m, -std::numeric_limits<double>::infinity(), light,
             cache_key) {}

bool LitScene::WantsSun(const Material& material, const RayHit& hit,
                        const Eigen::Vector3d& place_enu_m, const Eigen::Vector3f& direction_enu,
                        Eigen::Vector3d& start) const {
  if (sky_.sun_rgb().x() <= 0.0F) return false;
  const float to_sun = hit.normal_enu.dot(sky_.to_sun_enu());
  const float to_eye = -hit.normal_enu.dot(direction_enu);
  if (to_sun * to_eye <= 0.0F && !LetsLightThrough(material)) return false;
  start = place_enu_m +
          (to_sun > 0.0F ? kShadowOffset_m : -kShadowOffset_m) * hit.normal_enu.cast<double>();
  return true;
}

void LitScene::Shade(std::span<const SurfaceView> views, bool may_mirror, Memory& memory,
                     std::span<Eigen::Array3f> light) const {
  CORE_CHECK(views.size() <= SurfacePoints::kMost && light.size() >= views.size());
  std::array<Eigen::Vector3f, SurfacePoints::kMost> normals;
  std::array<float, SurfacePoints::kMost> cosines;
  SurfacePoints points;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const SurfaceView& view = views[i];
    const RayHit& hit = *view.hit;
    const float along = hit.normal_enu.dot(view.direction_enu);
    normals[i] = along > 0.0F ? Eigen::Vector3f(-hit.normal_enu) : hit.normal_enu;
    cosines[i] = std::max(std::abs(along), kMinGrazing);
    const float width_m = static_cast<float>(hit.range_m) * view.pixel_rad;
    points.u_m[i] = hit.uv_m.x();
    points.v_m[i] = hit.uv_m.y();
    points.footprint_u_m[i] =
        Footprint(hit.gradient_u, normals[i], view.direction_enu, -cosines[i], width_m);
    points.footprint_v_m[i] =
        Footprint(hit.gradient_v, normals[i], view.direction_enu, -cosines[i], width_m);
  }
  // Material by material: what is near in the picture is mostly of one.
  std::uint32_t left = (1U << views.size()) - 1U;
  SurfaceColours colours;
  while (left != 0) {
    const Material* material = views[static_cast<std::size_t>(std::countr_zero(left))].material;
    std::array<std::size_t, SurfacePoints::kMost> of{};
    std::size_t count = 0;
    SurfacePoints some;
    for (std::size_t i = 0; i < views.size(); ++i) {
      if ((left >> i & 1U) == 0 || views[i].material != material) continue;
      some.u_m[count] = points.u_m[i];
      some.v_m[count] = points.v_m[i];
      some.footprint_u_m[count] = points.footprint_u_m[i];
      some.footprint_v_m[count] = points.footprint_v_m[i];
      of[count++] = i;
      left &= ~(1U << i);
    }
    ColoursOf(*material, some, count, colours);
    for (std::size_t k = 0; k < count; ++k) {
      const SurfaceColour colour{{colours.red[k], colours.green[k], colours.blue[k]},
                                 colours.slope_u[k],
                                 colours.slope_v[k],
                                 colours.gloss[k],
                                 colours.luminance};
      const std::size_t i = of[k];
      light[i] = LightOf(views[i], normals[i], cosines[i], colour, may_mirror, memory);
    }
  }
}

Eigen::Array3f LitScene::LightOf(const SurfaceView& view, const Eigen::Vector3f& normal,
                                 float cosine, const SurfaceColour& colour, bool may_mirror,
                                 Memory& memory) const {
  const RayHit& hit = *view.hit;
  // Relief tilts the normal; the true surface still says what faces the sun at all.
  const Eigen::Vector3f relief =
      (normal - colour.slope_u * hit.gradient_u - colour.slope_v * hit.gradient_v).normalized();
  const Eigen::Array3f around = light_.At(view.place_enu_m, normal, memory.around);
  Eigen::Array3f light =
      around * (0.75F + 0.25F * relief.dot(normal) + 0.3F * (relief.z() - normal.z()));
  const Eigen::Vector3f& to_sun = sky_.to_sun_enu();
  if (view.sunlit) {
    const float facing = relief.dot(to_sun);
    if (normal.dot(to_sun) > 0.0F) light += std::max(facing, 0.0F) * sky_.sun_rgb();
    if (colour.luminance > 0.0F) light += colour.luminance * std::abs(facing) * sky_.sun_rgb();
  }
  Eigen::Array3f out = colour.rgb * light;

  if (colour.gloss > 0.0F) {
    // Schlick's approximation of Fresnel; rough things never become mirrors.
    const float grazing = Power<5>(1.0F - cosine);
    const float share =
        colour.gloss + (std::min(0.9F, 8.0F * colour.gloss) - colour.gloss) * grazing;
    const Eigen::Vector3f bounced =
        (view.direction_enu - 2.0F * relief.dot(view.direction_enu) * relief).normalized();
    Eigen::Array3f mirrored = Eigen::Array3f::Zero();
    if (view.material->pattern == Pattern::kGlass && may_mirror && share > kLeastMirror) {
      mirrored = Mirrored(view, bounced);
    } else {
      mirrored = light_.At(view.place_enu_m, bounced, memory.mirrored);
    }
    if (view.sunlit && normal.dot(to_sun) > 0.0F) {
      const float shine = std::max(bounced.dot(to_sun), 0.0F);
      mirrored += sky_.sun_rgb() * (6.0F * Power<80>(shine));
    }
    out = out * (1.0F - share) + mirrored * share;
  }
  const auto range_m = static_cast<float>(hit.range_m);
  const float haze = range_m / (range_m + kVisibility_m);
  return out + (sky_.haze_rgb() - out) * haze;
}

Eigen::Array3f LitScene::Mirrored(const SurfaceView& view, const Eigen::Vector3f& direction) const {
  const Eigen::Vector3d to = direction.cast<double>().normalized();
  const Eigen::Vector3d start = view.place_enu_m + 2.0 * kShadowOffset_m * to;
  const RayHit hit = rays_.Cast(start, to, view.moment);
  if (!hit.hit()) return sky_.Radiance(to.cast<float>());
  const Material& material = rays_.materials()[hit.material];
  SurfaceView far{
      &material, &hit,       start + hit.range_m * to, to.cast<float>(), kMirrorBlur_rad,
      false,     view.moment};
  Eigen::Vector3d off_surface;
  if (WantsSun(material, hit, far.place_enu_m, far.direction_enu, off_surface)) {
    far.sunlit = !rays_.Blocked(off_surface, sky_.to_sun_enu().cast<double>(),
                                std::numeric_limits<double>::infinity(), view.moment);
  }
  Memory own;
  Eigen::Array3f light;
  Shade({&far, 1}, false, own, {&light, 1});
  return light;
}

}  // namespace kawara::sim
