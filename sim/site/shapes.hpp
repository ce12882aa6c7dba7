#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "sim/site/building_config.hpp"
#include "sim/site/materials.hpp"
#include "sim/site/polygon.hpp"
#include "sim/site/seeds.hpp"
#include "sim/site/solid_builder.hpp"
#include "sim/site/thing_config.hpp"

/// The shapes of things, each built into the axes of a SolidBuilder: x along the heading, y left,
/// z up, origin on the ground. What is left to chance comes from `dice`.
namespace kawara::sim {

/// Where a shape puts its triangles and colours, and its chance.
struct Workshop {
  SolidBuilder& solid;
  Materials& materials;
  Dice& dice;
};

struct Size {
  double length_m;
  double width_m;
  double height_m;
};

/// The size of a thing: what the site file says, the rest drawn within what is usual.
Size SizeOf(const PropConfig& prop, Dice& dice);
void BuildProp(Workshop& shop, const PropConfig& prop, const Size& size);

void BuildCar(Workshop& shop, const Size& size, const Rgb& paint);
void BuildWagon(Workshop& shop, const Size& size, const Rgb& paint);
void BuildTruck(Workshop& shop, const Size& size, const Rgb& paint);
void BuildTree(Workshop& shop, const Size& size);
void BuildPole(Workshop& shop, const Size& size);
void BuildLamp(Workshop& shop, const Size& size);
void BuildPerson(Workshop& shop, const Size& size, const Rgb& coat);

/// Height of the ground in the builder's axes.
using LocalGround = std::function<double(double x_m, double y_m)>;

/// The heap lies along x and follows the ground, over kerbs too.
void BuildRubble(Workshop& shop, const RubbleConfig& heap, const LocalGround& ground);
struct RuinConfig;
void BuildRuin(Workshop& shop, const RuinConfig& ruin, const LocalGround& ground);

/// Along the line, whose corners stand on the ground in the builder's axes.
void BuildFence(Workshop& shop, const FenceConfig& fence,
                const std::vector<Vector3d>& line_on_ground);

/// `corners`: counter-clockwise in the builder's axes, side i starts at corner i; `foot_m`: how far
/// the walls reach into the ground (negative z).
void BuildBuilding(Workshop& shop, const BuildingConfig& building,
                   const std::vector<Vector2d>& corners, double foot_m);
/// `wall`: material of the gables.
void BuildRoof(Workshop& shop, const BuildingConfig& building, std::uint32_t wall,
               const std::vector<Vector2d>& corners);

}  // namespace kawara::sim
