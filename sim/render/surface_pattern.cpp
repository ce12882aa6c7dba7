#include "sim/render/surface_pattern.hpp"

#include "sim/render/pattern_tools.hpp"

namespace kawara::sim {
namespace {

/// A pixel longer than this many times its width is taken as shorter: a little aliasing along the
/// line of sight instead of all texture gone.
constexpr float kMaxStretch = 2.0F;

SurfaceColour Dispatch(const PatternPlace& p) {
  switch (p.material.pattern) {
    case Pattern::kPlain:
      return PlainColour(p);
    case Pattern::kAsphalt:
      return AsphaltColour(p);
    case Pattern::kConcrete:
      return ConcreteColour(p);
    case Pattern::kBrick:
      return BrickColour(p);
    case Pattern::kTiles:
      return TilesColour(p);
    case Pattern::kCorrugated:
      return CorrugatedColour(p);
    case Pattern::kGlass:
      return GlassColour(p);
    case Pattern::kWood:
      return WoodColour(p);
    case Pattern::kSoil:
      return SoilColour(p);
    case Pattern::kGrass:
      return GrassColour(p);
    case Pattern::kLeaves:
      return LeavesColour(p);
    case Pattern::kRubble:
      return RubbleColour(p);
    case Pattern::kCloth:
      return ClothColour(p);
  }
  return PlainColour(p);
}

}  // namespace

SurfaceColour ColourOf(const Material& material, const SurfacePoint& point) {
  const float narrow = std::min(point.footprint_u_m, point.footprint_v_m);
  const float wide = std::max(point.footprint_u_m, point.footprint_v_m);
  const float u = point.uv_m.x();
  const float v = point.uv_m.y();
  PatternPlace p{material,
                 RgbOf(material.base_rgb),
                 RgbOf(material.second_rgb),
                 u,
                 v,
                 point.footprint_u_m,
                 point.footprint_v_m,
                 std::min(wide, kMaxStretch * std::max(narrow, 1e-4F)),
                 HashCell(0, 0, material.seed),
                 material.contrast};
  // Joints stay where the surface's own metres have them (brick courses meet at corners); noise is
  // shifted by the seed inside the hashes.
  SurfaceColour colour = Dispatch(p);
  colour.rgb = colour.rgb.max(0.002F).min(0.98F);
  return colour;
}

NearestCells FindCells(float x, float y, std::uint32_t seed) {
  NearestCells found;
  const std::int32_t i = FloorInt(x);
  const std::int32_t j = FloorInt(y);
  for (std::int32_t dj = -1; dj <= 1; ++dj) {
    for (std::int32_t di = -1; di <= 1; ++di) {
      const std::uint32_t hash = HashCell(i + di, j + dj, seed);
      const float px = static_cast<float>(i + di) + static_cast<float>(hash & 0xFFFFU) / 65536.0F;
      const float py = static_cast<float>(j + dj) + static_cast<float>(hash >> 16) / 65536.0F;
      const float square = (px - x) * (px - x) + (py - y) * (py - y);
      if (square < found.first) {
        found.second = found.first;
        found.first = square;
        found.hash = hash;
      } else if (square < found.second) {
        found.second = square;
      }
    }
  }
  found.first = std::sqrt(found.first);
  found.second = std::sqrt(found.second);
  return found;
}

}  // namespace kawara::sim
