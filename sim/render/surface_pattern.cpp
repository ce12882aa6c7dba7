#include "sim/render/surface_pattern.hpp"

#include "sim/render/noise2.hpp"

// Highway compiles this file once for each SIMD target; the table of targets is at the bottom.
// Vectors without a fixed size (SVE) cannot be members, as lane_math has them.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/render/surface_pattern.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "sim/render/pattern_ground_inl.hpp"
#include "sim/render/pattern_masonry_inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace kawara::sim::HWY_NAMESPACE {

/// A pixel longer than this many times its width is taken as shorter: a little aliasing along the
/// line of sight instead of all texture gone.
constexpr float kMaxStretch = 2.0F;

Look LookOf(const PatternPlace& p) {
  switch (p.material.pattern) {
    case Pattern::kPlain:
      return PlainLook(p);
    case Pattern::kAsphalt:
      return AsphaltLook(p);
    case Pattern::kConcrete:
      return ConcreteLook(p);
    case Pattern::kBrick:
      return BrickLook(p);
    case Pattern::kTiles:
      return TilesLook(p);
    case Pattern::kCorrugated:
      return CorrugatedLook(p);
    case Pattern::kGlass:
      return GlassLook(p);
    case Pattern::kWood:
      return WoodLook(p);
    case Pattern::kSoil:
      return SoilLook(p);
    case Pattern::kGrass:
      return GrassLook(p);
    case Pattern::kLeaves:
      return LeavesLook(p);
    case Pattern::kRubble:
      return RubbleLook(p);
    case Pattern::kCloth:
      return ClothLook(p);
  }
  return PlainLook(p);
}

void Colours(const Material& material, const SurfacePoints& points, std::size_t count,
             SurfaceColours& out) {
  const FloatTag lanes;
  const std::uint32_t seed = HashCell(0, 0, material.seed);
  for (std::size_t first = 0; first < count; first += hn::Lanes(lanes)) {
    // Joints stay where the surface's own metres have them (brick courses meet at corners); noise
    // is shifted by the seed inside the hashes.
    const F width_u(hn::Load(lanes, points.footprint_u_m.data() + first));
    const F width_v(hn::Load(lanes, points.footprint_v_m.data() + first));
    const F narrow = Max(Min(width_u, width_v), 1e-4F);
    const F width = Min(Max(width_u, width_v), F(kMaxStretch) * narrow);
    const PatternPlace place{material,
                             RgbOf(material.base_rgb),
                             RgbOf(material.second_rgb),
                             F(hn::Load(lanes, points.u_m.data() + first)),
                             F(hn::Load(lanes, points.v_m.data() + first)),
                             width_u,
                             width_v,
                             width,
                             F(1.0F) / Max(width_u, 1e-6F),
                             F(1.0F) / Max(width_v, 1e-6F),
                             F(1.0F) / Max(width, 1e-6F),
                             seed,
                             material.contrast};
    const Look look = LookOf(place);
    const F least = 0.002F;
    const F most = 0.98F;
    hn::Store(Min(Max(look.rgb.r, least), most).v, lanes, out.red.data() + first);
    hn::Store(Min(Max(look.rgb.g, least), most).v, lanes, out.green.data() + first);
    hn::Store(Min(Max(look.rgb.b, least), most).v, lanes, out.blue.data() + first);
    hn::Store(look.slope_u.v, lanes, out.slope_u.data() + first);
    hn::Store(look.slope_v.v, lanes, out.slope_v.data() + first);
    hn::Store(look.gloss.v, lanes, out.gloss.data() + first);
    out.luminance = look.luminance;
  }
}

}  // namespace kawara::sim::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kawara::sim {

HWY_EXPORT(Colours);

void ColoursOf(const Material& material, const SurfacePoints& points, std::size_t count,
               SurfaceColours& colours) {
  HWY_DYNAMIC_DISPATCH(Colours)(material, points, count, colours);
}

SurfaceColour ColourOf(const Material& material, const SurfacePoint& point) {
  SurfacePoints points;
  points.u_m[0] = point.uv_m.x();
  points.v_m[0] = point.uv_m.y();
  points.footprint_u_m[0] = point.footprint_u_m;
  points.footprint_v_m[0] = point.footprint_v_m;
  SurfaceColours colours;
  ColoursOf(material, points, 1, colours);
  return {{colours.red[0], colours.green[0], colours.blue[0]},
          colours.slope_u[0],
          colours.slope_v[0],
          colours.gloss[0],
          colours.luminance};
}

}  // namespace kawara::sim
#endif
