#include <array>
#include <cmath>

#include "sim/site/shapes.hpp"

namespace kawara::sim {
namespace {

/// A ball of foliage: a dark core that nothing shines through, and leaves all over it.
struct Clump {
  Vector3d centre;
  Vector3d half;
};

Vector3d Direction(Dice& dice) {
  const double z = Between(dice, -1.0, 1.0);
  const double turn = 2.0 * core::kPi * dice.Uniform();
  const double r = std::sqrt(std::max(0.0, 1.0 - z * z));
  return {r * std::cos(turn), r * std::sin(turn), z};
}

void Core(Workshop& shop, std::uint32_t material, const Clump& clump) {
  std::vector<Ring> rings;
  constexpr int kRings = 7;
  for (int i = 0; i <= kRings; ++i) {
    const double t = core::kPi * (0.05 + 0.90 * i / kRings);
    const double r = std::sin(t) * Between(shop.dice, 0.86, 1.0);
    rings.push_back({clump.centre - Vector3d(0, 0, clump.half.z() * std::cos(t)),
                     Vector3d(clump.half.x() * r, 0, 0), Vector3d(0, clump.half.y() * r, 0)});
  }
  shop.solid.Loft(material, rings, 12);
}

/// A pointed leaf spray: two triangles folded along its rib, facing about outwards.
void Leaf(Workshop& shop, std::uint32_t material, const Vector3d& at, const Vector3d& out,
          double length_m) {
  const Vector3d facing = (out + 0.7 * Direction(shop.dice)).normalized();
  const Vector3d rib = (Direction(shop.dice).cross(facing) + 0.3 * facing).normalized();
  const Vector3d across = facing.cross(rib).normalized();
  const Vector3d tip = at + rib * length_m;
  const Vector3d middle = at + rib * (length_m * 0.45) - facing * (length_m * 0.08);
  const Vector3d left = middle + across * (length_m * 0.36) + facing * (length_m * 0.08);
  const Vector3d right = middle - across * (length_m * 0.36) + facing * (length_m * 0.08);
  // Counter-clockwise about `facing`.
  shop.solid.Triangle(material, at, right, tip);
  shop.solid.Triangle(material, at, tip, left);
}

}  // namespace

void BuildTree(Workshop& shop, const Size& size) {
  Dice& dice = shop.dice;
  const double hue = Between(dice, 0.75, 1.25);
  const std::uint32_t bark = shop.materials.Add(Pattern::kWood, {0.12, 0.085, 0.06}, dice.Next());
  const std::array leaves{
      shop.materials.Add(Pattern::kLeaves, {0.050 * hue, 0.105, 0.028}, dice.Next()),
      shop.materials.Add(Pattern::kLeaves, {0.085 * hue, 0.150, 0.040}, dice.Next()),
      shop.materials.Add(Pattern::kLeaves, {0.033 * hue, 0.075, 0.022}, dice.Next())};
  const std::uint32_t shade =
      shop.materials.Add(Pattern::kLeaves, {0.02, 0.04, 0.012}, dice.Next());
  const double h = size.height_m, crown_r = (size.length_m + size.width_m) / 4.0;
  const double trunk_top = h * 0.38, crown_z = h * 0.64, crown_h = h * 0.36;
  const double girth = 0.022 * h + 0.04;
  const Vector3d lean(Between(dice, -0.15, 0.15), Between(dice, -0.15, 0.15), trunk_top);
  const std::array trunk{
      Ring{Vector3d(0, 0, -0.2), Vector3d(girth * 1.5, 0, 0), Vector3d(0, girth * 1.5, 0)},
      Ring{Vector3d(0, 0, 0.15), Vector3d(girth * 1.1, 0, 0), Vector3d(0, girth * 1.1, 0)},
      Ring{lean * 0.6, Vector3d(girth * 0.9, 0, 0), Vector3d(0, girth * 0.9, 0)},
      Ring{lean, Vector3d(girth * 0.75, 0, 0), Vector3d(0, girth * 0.75, 0)}};
  shop.solid.Loft(bark, trunk, 14);
  constexpr int kClumps = 9;
  std::vector<Clump> clumps;
  for (int i = 0; i < kClumps; ++i) {
    const double turn = 2.0 * core::kPi * (i + Between(dice, -0.3, 0.3)) / (kClumps - 2);
    const bool top = i >= kClumps - 2;
    const double reach = top ? crown_r * 0.2 : crown_r * Between(dice, 0.42, 0.58);
    const double r = crown_r * Between(dice, 0.40, 0.52);
    const double z = top ? crown_z + crown_h * Between(dice, 0.3, 0.6)
                         : crown_z + crown_h * Between(dice, -0.45, 0.25);
    clumps.push_back({Vector3d(lean.x() + reach * std::cos(turn), lean.y() + reach * std::sin(turn),
                               std::min(z, h - r * 0.8)),
                      Vector3d(r, r, r * 0.8)});
    shop.solid.Tube(bark, lean * 0.97, clumps.back().centre, girth * 0.45, girth * 0.15, 8);
  }
  constexpr double kLeavesPerM2 = 60.0;
  for (const Clump& clump : clumps) {
    Core(shop, shade, {clump.centre, clump.half * 0.80});
    const double area = 4.0 * core::kPi * clump.half.x() * clump.half.z();
    const int count = static_cast<int>(area * kLeavesPerM2);
    for (int i = 0; i < count; ++i) {
      const Vector3d out = Direction(dice);
      const Vector3d at = clump.centre + clump.half.cwiseProduct(out) * Between(dice, 0.72, 1.08);
      Leaf(shop, leaves[static_cast<std::size_t>(Pick(dice, 3))], at, out,
           Between(dice, 0.12, 0.26));
    }
  }
}

}  // namespace kawara::sim
