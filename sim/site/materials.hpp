#pragma once
#include <cstdint>

#include "sim/site/scene.hpp"
#include "sim/site/thing_config.hpp"

namespace kawara::sim {

/// What is usual for a pattern: colours, size of its unit, gloss. Reflectances after tables of
/// common building materials (fresh to weathered, linear light).
Material UsualMaterial(Pattern pattern);

/// Puts materials into a scene; each call makes one. One thread.
class Materials {
 public:
  explicit Materials(Scene& scene) : scene_(scene) {}

  std::uint32_t Add(const Material& material);
  std::uint32_t Add(Pattern pattern, std::uint64_t seed);
  std::uint32_t Add(Pattern pattern, const Rgb& rgb, std::uint64_t seed);
  std::uint32_t Add(const SurfaceConfig& surface, std::uint64_t seed);
  /// Smooth and shiny, as on cars.
  std::uint32_t Paint(const Rgb& rgb, float gloss);

 private:
  Scene& scene_;
};

}  // namespace kawara::sim
