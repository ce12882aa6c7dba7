#pragma once
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sim/site/scene.hpp"
#include "sim/site/site_config.hpp"
#include "sim/site/terrain.hpp"

namespace kawara::sim {

/// A building after its collapse: a heap with walls leaning on it.
struct RuinConfig {
  RubbleConfig heap;
  BuildingConfig building;  ///< as it stood
};

/// One thing with its place settled: what rows and scatter rules come to, and what the site file
/// names itself.
struct Placed {
  std::uint32_t id = 0;
  std::string name;
  ObjectClass cls = ObjectClass::kClutter;
  Existence state = Existence::kKnown;
  std::optional<double> begin_s;
  std::optional<double> end_s;
  std::uint64_t seed = 0;  ///< of its own chance
  Eigen::Vector2d at_m = Eigen::Vector2d::Zero();
  double heading_rad = 0.0;
  std::variant<PropConfig, BuildingConfig, FenceConfig, RubbleConfig, RuinConfig> what;
};

/// Every thing of a site in every state, ids ascending from `first_id`; the same for the same
/// configuration.
std::vector<Placed> PlaceThings(const SiteConfig& site, const Terrain& terrain,
                                std::uint32_t first_id);

/// A dwelling house made by rule, facing `heading_deg`.
BuildingConfig MakeHouse(const HouseRuleConfig& rule, const EastNorth& at_m, double heading_deg,
                         std::uint64_t seed);

}  // namespace kawara::sim
