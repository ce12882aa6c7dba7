#include <cmath>

#include "sim/site/placement.hpp"
#include "sim/site/shapes.hpp"

namespace kawara::sim {
namespace {

/// A piece of outer wall with the hole of a window, its foot along x at the frame's origin.
void WallPiece(Workshop& shop, std::uint32_t wall, std::uint32_t inside, std::uint32_t frame,
               const Frame& at, double width_m, double height_m) {
  const double t = 0.14, w = width_m / 2.0;
  const double x0 = -w * 0.45, x1 = w * 0.35, z0 = height_m * 0.38, z1 = height_m * 0.80;
  SolidBuilder& s = shop.solid;
  const auto part = [&](double xa, double xb, double za, double zb) {
    s.BoxBetween(wall, at, {xa, -t / 2, za}, {xb, t / 2 - 0.03, zb});
    s.BoxBetween(inside, at, {xa, t / 2 - 0.03, za}, {xb, t / 2, zb});
  };
  part(-w, w, 0, z0);
  part(-w, x0, z0, z1);
  part(x1, w, z0, z1);
  part(-w * Between(shop.dice, 0.6, 1.0), w * Between(shop.dice, 0.6, 1.0), z1, height_m);
  constexpr double kBar_m = 0.05;
  for (const double x : {x0, (x0 + x1) / 2, x1 - kBar_m})
    s.BoxBetween(frame, at, {x, -0.04, z0}, {x + kBar_m, 0.02, z1});
  s.BoxBetween(frame, at, {x0, -0.04, z0}, {x1, 0.02, z0 + kBar_m});
}

/// Half a roof, tiles up, with rafters under it.
void RoofPiece(Workshop& shop, std::uint32_t tiles, std::uint32_t wood, const Frame& at,
               double length_m, double span_m) {
  SolidBuilder& s = shop.solid;
  s.BoxBetween(tiles, at, {-length_m / 2, -span_m / 2, 0}, {length_m / 2, span_m / 2, 0.09});
  for (double x = -length_m / 2 + 0.2; x < length_m / 2; x += 0.6)
    s.BoxBetween(wood, at, {x, -span_m / 2 - Between(shop.dice, 0.0, 0.4), -0.12},
                 {x + 0.08, span_m / 2 + Between(shop.dice, 0.0, 0.5), 0.0});
}

}  // namespace

void BuildRuin(Workshop& shop, const RuinConfig& ruin, const LocalGround& ground) {
  Dice& dice = shop.dice;
  BuildRubble(shop, ruin.heap, ground);
  const BuildingConfig& house = ruin.building;
  const std::uint32_t wall = shop.materials.Add(house.wall, dice.Next());
  const std::uint32_t inside = shop.materials.Add(Pattern::kPlain, {0.55, 0.52, 0.45}, dice.Next());
  const std::uint32_t frame = shop.materials.Paint({0.45, 0.46, 0.46}, 0.05F);
  const std::uint32_t wood = shop.materials.Add(Pattern::kWood, dice.Next());
  const std::uint32_t tiles = shop.materials.Add(house.roof.surface, dice.Next());
  const double a = ruin.heap.size_m[0] / 2, b = ruin.heap.size_m[1] / 2;
  const int walls = house.collapse ? house.collapse->leaning_walls : 0;
  for (int i = 0; i < walls; ++i) {
    const double turn = 2.0 * core::kPi * (i + Between(dice, 0.1, 0.6)) / walls + 0.4;
    const double share = Between(dice, 0.55, 0.72);
    // Feet stand about the heap; tops lean in on it.
    const double x = a * share * std::cos(turn), y = b * share * std::sin(turn);
    const Frame foot = Shift(x, y, ground(x, y) - 0.1) *
                       TurnZ(turn + core::kPi / 2 + Between(dice, -0.25, 0.25)) *
                       TurnX(Between(dice, 0.45, 0.95)) * TurnY(Between(dice, -0.12, 0.12));
    WallPiece(shop, wall, inside, frame, foot, Between(dice, 2.2, 3.8), Between(dice, 2.0, 2.8));
  }
  const double top = ruin.heap.height_m;
  for (const double side : {-1.0, 1.0}) {
    const Frame at = Shift(-a * 0.10 + Between(dice, -0.4, 0.4), side * b * 0.34, top * 0.80) *
                     TurnZ(Between(dice, -0.3, 0.3)) * TurnX(side * -Between(dice, 0.25, 0.5)) *
                     TurnY(Between(dice, -0.12, 0.22));
    RoofPiece(shop, tiles, wood, at, a * Between(dice, 0.9, 1.15), b * Between(dice, 0.55, 0.75));
  }
}

}  // namespace kawara::sim
