#include "sim/site/materials.hpp"

#include <algorithm>

namespace kawara::sim {
namespace {

std::array<float, 3> Floats(const Rgb& rgb) {
  return {static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2])};
}

/// The second tone of a colour that replaces the usual one keeps the usual relation to it, except
/// for joints, which are mortar whatever the stone is.
std::array<float, 3> SecondTone(const Material& usual, const std::array<float, 3>& base) {
  if (usual.pattern == Pattern::kBrick || usual.pattern == Pattern::kTiles) return usual.second_rgb;
  std::array<float, 3> second{};
  for (std::size_t i = 0; i < 3; ++i)
    second[i] = std::min(1.0F, base[i] * usual.second_rgb[i] / usual.base_rgb[i]);
  return second;
}

}  // namespace

Material UsualMaterial(Pattern pattern) {
  Material m;
  m.pattern = pattern;
  const auto set = [&m](std::array<float, 3> base, std::array<float, 3> second, float scale_m,
                        float gloss) {
    m.base_rgb = base;
    m.second_rgb = second;
    m.scale_m = scale_m;
    m.gloss = gloss;
  };
  switch (pattern) {
    case Pattern::kPlain:
      set({0.60F, 0.59F, 0.56F}, {0.50F, 0.49F, 0.47F}, 1.0F, 0.0F);
      break;
    case Pattern::kAsphalt:
      set({0.095F, 0.095F, 0.098F}, {0.16F, 0.155F, 0.15F}, 0.02F, 0.0F);
      break;
    case Pattern::kConcrete:
      set({0.40F, 0.385F, 0.36F}, {0.30F, 0.29F, 0.27F}, 1.8F, 0.0F);
      break;
    case Pattern::kBrick:
      set({0.32F, 0.12F, 0.075F}, {0.42F, 0.39F, 0.35F}, 0.075F, 0.0F);
      break;
    case Pattern::kTiles:
      set({0.34F, 0.31F, 0.28F}, {0.20F, 0.19F, 0.18F}, 0.30F, 0.0F);
      break;
    case Pattern::kCorrugated:
      set({0.42F, 0.46F, 0.46F}, {0.30F, 0.33F, 0.33F}, 0.076F, 0.02F);
      break;
    case Pattern::kGlass:
      set({0.035F, 0.045F, 0.05F}, {0.05F, 0.06F, 0.065F}, 1.0F, 0.12F);
      break;
    case Pattern::kWood:
      set({0.30F, 0.19F, 0.105F}, {0.20F, 0.12F, 0.065F}, 0.12F, 0.0F);
      break;
    case Pattern::kSoil:
      set({0.22F, 0.17F, 0.12F}, {0.32F, 0.27F, 0.21F}, 0.08F, 0.0F);
      break;
    case Pattern::kGrass:
      set({0.085F, 0.13F, 0.04F}, {0.16F, 0.17F, 0.07F}, 0.10F, 0.0F);
      break;
    case Pattern::kLeaves:
      set({0.055F, 0.105F, 0.03F}, {0.12F, 0.18F, 0.05F}, 0.08F, 0.0F);
      break;
    case Pattern::kRubble:
      set({0.36F, 0.34F, 0.31F}, {0.22F, 0.20F, 0.18F}, 0.25F, 0.0F);
      break;
    case Pattern::kCloth:
      set({0.10F, 0.12F, 0.22F}, {0.07F, 0.08F, 0.15F}, 0.03F, 0.0F);
      break;
  }
  return m;
}

std::uint32_t Materials::Add(const Material& material) {
  scene_.materials.push_back(material);
  return static_cast<std::uint32_t>(scene_.materials.size() - 1);
}

std::uint32_t Materials::Add(Pattern pattern, std::uint64_t seed) {
  Material m = UsualMaterial(pattern);
  m.seed = static_cast<std::uint32_t>(seed);
  return Add(m);
}

std::uint32_t Materials::Add(Pattern pattern, const Rgb& rgb, std::uint64_t seed) {
  Material m = UsualMaterial(pattern);
  const std::array<float, 3> base = Floats(rgb);
  m.second_rgb = SecondTone(m, base);
  m.base_rgb = base;
  m.seed = static_cast<std::uint32_t>(seed);
  return Add(m);
}

std::uint32_t Materials::Add(const SurfaceConfig& surface, std::uint64_t seed) {
  const std::uint32_t index =
      surface.rgb ? Add(surface.pattern, *surface.rgb, seed) : Add(surface.pattern, seed);
  Material& m = scene_.materials[index];
  if (surface.scale_m) m.scale_m = static_cast<float>(*surface.scale_m);
  if (surface.contrast) m.contrast = static_cast<float>(*surface.contrast);
  return index;
}

std::uint32_t Materials::Paint(const Rgb& rgb, float gloss) {
  Material m = UsualMaterial(Pattern::kPlain);
  m.base_rgb = Floats(rgb);
  m.second_rgb = m.base_rgb;
  m.contrast = 0.0F;
  m.gloss = gloss;
  return Add(m);
}

}  // namespace kawara::sim
