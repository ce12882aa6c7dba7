#pragma once
#include <cstdint>

#include "sim/site/scene.hpp"
#include "sim/site/site_config.hpp"
#include "sim/site/terrain.hpp"

namespace kawara::sim {

enum class SiteState : std::uint8_t {
  kBefore,  ///< what the reference knows: all things but the new ones
  kAfter,   ///< what the robot meets: all things but those that are gone
};

/// The site as geometry. An object has the same id, shape and place in both states; the states
/// differ by the things that are gone or new and by nothing else. Same configuration: same bytes.
/// Objects 1 to 3 are the ground and the kerbs (left, right). Heaps and walls reach some way into
/// the ground. `terrain` must be the site's.
Scene BuildScene(const SiteConfig& site, const Terrain& terrain, SiteState state);
Scene BuildScene(const SiteConfig& site, SiteState state);

/// Smallest upright box at a heading around all vertices of an object's meshes.
UprightBox BoxAround(const Scene& scene, std::uint32_t object, double heading_rad);

}  // namespace kawara::sim
