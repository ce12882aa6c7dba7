#include <array>
#include <cmath>

#include "sim/site/placement.hpp"
#include "sim/site/seeds.hpp"

namespace kawara::sim {

BuildingConfig MakeHouse(const HouseRuleConfig& rule, const EastNorth& at_m, double heading_deg,
                         std::uint64_t seed) {
  Dice dice(seed);
  BuildingConfig house;
  const double frontage = Between(dice, rule.frontage_m[0], rule.frontage_m[1]);
  const double depth = Between(dice, rule.depth_m[0], rule.depth_m[1]);
  house.storeys = rule.storeys[0] + Pick(dice, rule.storeys[1] - rule.storeys[0] + 1);
  house.height_m = house.storeys * Between(dice, 2.75, 2.95) + 0.35;
  house.rectangle = RectangleConfig{at_m, {depth, frontage}, heading_deg};
  constexpr std::array<Rgb, 7> kWalls{{{0.58, 0.55, 0.48},
                                       {0.66, 0.65, 0.61},
                                       {0.44, 0.37, 0.28},
                                       {0.35, 0.37, 0.37},
                                       {0.56, 0.47, 0.33},
                                       {0.30, 0.21, 0.15},
                                       {0.50, 0.53, 0.52}}};
  constexpr std::array<Pattern, 5> kPatterns{Pattern::kConcrete, Pattern::kPlain, Pattern::kTiles,
                                             Pattern::kWood, Pattern::kBrick};
  house.wall.pattern = kPatterns[static_cast<std::size_t>(Pick(dice, 5))];
  if (house.wall.pattern != Pattern::kBrick)
    house.wall.rgb = kWalls[static_cast<std::size_t>(Pick(dice, 7))];
  if (house.wall.pattern == Pattern::kTiles) house.wall.scale_m = 0.095;
  constexpr std::array<Rgb, 5> kRoofs{{{0.085, 0.09, 0.10},
                                       {0.15, 0.155, 0.16},
                                       {0.21, 0.085, 0.055},
                                       {0.06, 0.08, 0.12},
                                       {0.13, 0.09, 0.065}}};
  house.roof.type = Chance(dice, 0.6) ? RoofType::kGable : RoofType::kHip;
  house.roof.rise_m = std::min(frontage, depth) / 2.0 * Between(dice, 0.40, 0.58);
  house.roof.eaves_m = Between(dice, 0.45, 0.75);
  house.roof.surface = {Pattern::kTiles, kRoofs[static_cast<std::size_t>(Pick(dice, 5))], 0.28, {}};
  WindowsConfig windows;
  windows.width_m = Between(dice, 1.5, 1.8);
  windows.height_m = Between(dice, 1.0, 1.25);
  windows.sill_m = 0.95;
  windows.spacing_m = Between(dice, 2.4, 3.2);
  windows.blank_share = 0.2;
  house.windows = windows;
  const double door_at = frontage * (Chance(dice, 0.5) ? 0.22 : 0.78);
  constexpr std::array<Rgb, 4> kDoors{
      {{0.16, 0.09, 0.05}, {0.10, 0.11, 0.12}, {0.30, 0.20, 0.11}, {0.07, 0.12, 0.10}}};
  house.doors.push_back(
      {0, door_at, 0.95, 2.15, DoorKind::kDoor, kDoors[static_cast<std::size_t>(Pick(dice, 4))]});
  house.plinth_m = Between(dice, 0.35, 0.5);
  return house;
}

}  // namespace kawara::sim
