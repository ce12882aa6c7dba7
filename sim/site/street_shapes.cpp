#include <array>
#include <cmath>

#include "sim/site/shapes.hpp"

namespace kawara::sim {
namespace {

Ring LevelRing(double x, double y, double z, double half_x, double half_y) {
  return {Vector3d(x, y, z), Vector3d(half_x, 0, 0), Vector3d(0, half_y, 0)};
}

void BuildBox(Workshop& shop, const Size& size, const Rgb& rgb) {
  const std::uint32_t board = shop.materials.Paint(rgb, 0.0F);
  const std::uint32_t tape =
      shop.materials.Paint({rgb[0] * 0.6, rgb[1] * 0.55, rgb[2] * 0.45}, 0.0F);
  shop.solid.Box(board, Frame::Identity(), {size.length_m, size.width_m, size.height_m});
  shop.solid.Box(tape, Shift(0, 0, size.height_m - 0.12), {size.length_m + 0.004, 0.06, 0.122});
}

void BuildPallet(Workshop& shop, const Size& size) {
  const std::uint32_t wood = shop.materials.Add(Pattern::kWood, shop.dice.Next());
  const std::uint32_t load =
      shop.materials.Add(Pattern::kPlain, {0.42, 0.31, 0.19}, shop.dice.Next());
  const double l = size.length_m, w = size.width_m;
  for (int i = -1; i <= 1; ++i)
    shop.solid.Box(wood, Shift(0, i * (w / 2 - 0.05), 0), {l, 0.10, 0.12});
  for (int i = 0; i < 6; ++i)
    shop.solid.Box(wood, Shift(-l / 2 + 0.06 + (l - 0.12) * i / 5.0, 0, 0.12), {0.11, w, 0.02});
  // Cartons, in courses that break the joints.
  const int courses = std::max(1, static_cast<int>((size.height_m - 0.14) / 0.36));
  for (int k = 0; k < courses; ++k) {
    const int columns = k % 2 == 0 ? 2 : 3;
    for (int i = 0; i < columns; ++i) {
      for (int j = 0; j < 2; ++j) {
        const double x = -l / 2 + l * (i + 0.5) / columns;
        const double y = -w / 2 + w * (j + 0.5) / 2;
        if (k == courses - 1 && Chance(shop.dice, 0.3)) continue;
        shop.solid.Box(load, Shift(x, y, 0.14 + 0.36 * k) * TurnZ(Between(shop.dice, -0.03, 0.03)),
                       {l / columns - 0.02, w / 2 - 0.02, 0.355});
      }
    }
  }
}

void BuildCone(Workshop& shop, const Size& size) {
  const std::uint32_t orange = shop.materials.Paint({0.72, 0.13, 0.02}, 0.02F);
  const std::uint32_t white = shop.materials.Paint({0.75, 0.75, 0.74}, 0.02F);
  const double h = size.height_m, r = size.length_m * 0.36;
  shop.solid.Box(orange, Frame::Identity(), {size.length_m, size.width_m, 0.035});
  const auto radius = [&](double z) { return r + (0.03 - r) * (z - 0.035) / (h - 0.035); };
  const std::array levels{0.035, 0.35 * h, 0.55 * h, 0.68 * h, 0.86 * h, h};
  for (std::size_t i = 0; i + 1 < levels.size(); ++i)
    shop.solid.Tube(i % 2 == 0 ? orange : white, Vector3d(0, 0, levels[i]),
                    Vector3d(0, 0, levels[i + 1]), radius(levels[i]), radius(levels[i + 1]), 20);
}

void BuildDrum(Workshop& shop, const Size& size, const Rgb& rgb) {
  const std::uint32_t paint = shop.materials.Paint(rgb, 0.04F);
  const double r = size.length_m / 2.0, h = size.height_m;
  std::vector<Ring> rings;
  for (const auto& [z, grow] : {std::pair{0.0, 1.0},
                                {0.02, 1.0},
                                {0.03, 0.97},
                                {0.32, 0.97},
                                {0.335, 1.0},
                                {0.35, 0.97},
                                {0.65, 0.97},
                                {0.665, 1.0},
                                {0.68, 0.97},
                                {0.97, 0.97},
                                {0.98, 1.0},
                                {1.0, 1.0}})
    rings.push_back(LevelRing(0, 0, z * h, r * grow, r * grow));
  shop.solid.Loft(paint, rings, 28);
}

void BuildSign(Workshop& shop, const Size& size, const Rgb& rgb) {
  const std::uint32_t steel = shop.materials.Paint({0.48, 0.49, 0.50}, 0.08F);
  const std::uint32_t face = shop.materials.Paint(rgb, 0.05F);
  const std::uint32_t rim = shop.materials.Paint({0.75, 0.75, 0.74}, 0.05F);
  const double h = size.height_m, r = size.width_m / 2.0;
  shop.solid.Tube(steel, Vector3d(0, 0, 0), Vector3d(0, 0, h), 0.03, 0.03, 12);
  const double z = h - r - 0.05;
  shop.solid.Tube(rim, Vector3d(0.032, 0, z), Vector3d(0.040, 0, z), r, r, 32);
  shop.solid.Tube(face, Vector3d(0.040, 0, z), Vector3d(0.043, 0, z), r * 0.86, r * 0.86, 32);
  shop.solid.Box(rim, Shift(0.044, 0, z - 0.05), {0.004, r * 1.2, 0.10});
}

}  // namespace

void BuildPole(Workshop& shop, const Size& size) {
  Materials& m = shop.materials;
  const std::uint32_t concrete = m.Add(Pattern::kConcrete, {0.42, 0.41, 0.39}, shop.dice.Next());
  const std::uint32_t steel = m.Paint({0.40, 0.41, 0.42}, 0.06F);
  const std::uint32_t china = m.Paint({0.68, 0.68, 0.66}, 0.10F);
  const std::uint32_t band = m.Paint({0.62, 0.50, 0.04}, 0.0F);
  const std::uint32_t black = m.Paint({0.03, 0.03, 0.03}, 0.0F);
  const double h = size.height_m;
  constexpr double kFoot_m = 0.165, kTop_m = 0.095;
  shop.solid.Tube(concrete, Vector3d(0, 0, -0.3), Vector3d(0, 0, h), kFoot_m, kTop_m, 20);
  // Warning sleeve at the height of drivers' eyes.
  for (int i = 0; i < 6; ++i)
    shop.solid.Tube(i % 2 == 0 ? band : black, Vector3d(0, 0, 0.5 + 0.2 * i),
                    Vector3d(0, 0, 0.7 + 0.2 * i), kFoot_m + 0.004, kFoot_m + 0.002, 20);
  // Cross-arms lie across the heading, which is that of the line.
  for (const double z : {h - 0.45, h - 1.35}) {
    shop.solid.Box(steel, Shift(0.14, 0, z), {0.075, size.width_m, 0.075});
    for (int i = -2; i <= 2; ++i) {
      const double y = i * (size.width_m / 2 - 0.12) / 2.0;
      const std::array rings{
          LevelRing(0.14, y, z + 0.075, 0.02, 0.02), LevelRing(0.14, y, z + 0.10, 0.055, 0.055),
          LevelRing(0.14, y, z + 0.15, 0.035, 0.035), LevelRing(0.14, y, z + 0.18, 0.05, 0.05),
          LevelRing(0.14, y, z + 0.23, 0.02, 0.02)};
      if (i != 0) shop.solid.Loft(china, rings, 10);
    }
    for (const double side : {-1.0, 1.0})  // braces
      shop.solid.Tube(steel, Vector3d(0.14, side * size.width_m * 0.3, z),
                      Vector3d(0.12, 0, z - 0.45), 0.014, 0.014, 6);
  }
  if (Chance(shop.dice, 0.4)) {  // transformer
    const std::uint32_t can = m.Paint({0.42, 0.44, 0.45}, 0.04F);
    const std::array rings{LevelRing(0, 0.42, h - 2.75, 0.24, 0.24),
                           LevelRing(0, 0.42, h - 2.0, 0.26, 0.26),
                           LevelRing(0, 0.42, h - 1.94, 0.18, 0.18)};
    shop.solid.Loft(can, rings, 20);
    shop.solid.Box(steel, Shift(0, 0.2, h - 2.5), {0.10, 0.4, 0.08});
  }
  for (int i = 0; i < 8; ++i)  // climbing bolts
    shop.solid.Tube(steel, Vector3d(0, (i % 2 == 0 ? 1 : -1) * 0.10, 2.2 + 0.45 * i),
                    Vector3d(0, (i % 2 == 0 ? 1 : -1) * 0.27, 2.2 + 0.45 * i), 0.009, 0.009, 6);
}

void BuildLamp(Workshop& shop, const Size& size) {
  const std::uint32_t steel = shop.materials.Paint({0.36, 0.38, 0.38}, 0.06F);
  const std::uint32_t glow = shop.materials.Paint({0.80, 0.80, 0.76}, 0.10F);
  const double h = size.height_m, reach = size.length_m;
  shop.solid.Tube(steel, Vector3d(0, 0, -0.2), Vector3d(0, 0, 0.9), 0.095, 0.09, 16);
  shop.solid.Tube(steel, Vector3d(0, 0, 0.9), Vector3d(0, 0, h - 0.6), 0.065, 0.05, 16);
  const int bends = 6;
  Vector3d last(0, 0, h - 0.6);
  for (int i = 1; i <= bends; ++i) {
    const double t = core::kPi / 2.0 * i / bends;
    const Vector3d next(reach * (1 - std::cos(t)), 0, h - 0.6 + 0.5 * std::sin(t));
    shop.solid.Tube(steel, last, next, 0.045, 0.042, 12);
    last = next;
  }
  shop.solid.Box(steel, Shift(reach + 0.2, 0, h - 0.12), {0.60, 0.24, 0.10});
  shop.solid.Box(glow, Shift(reach + 0.22, 0, h - 0.15), {0.45, 0.18, 0.035});
}

void BuildPerson(Workshop& shop, const Size& size, const Rgb& coat) {
  Materials& m = shop.materials;
  Dice& dice = shop.dice;
  const std::uint32_t cloth = m.Add(Pattern::kCloth, coat, dice.Next());
  const std::uint32_t trousers = m.Add(Pattern::kCloth, {0.05, 0.055, 0.08}, dice.Next());
  const std::uint32_t skin = m.Paint({0.46, 0.29, 0.21}, 0.0F);
  const std::uint32_t hair = m.Paint({0.02, 0.017, 0.015}, 0.0F);
  const std::uint32_t shoe = m.Paint({0.03, 0.028, 0.026}, 0.0F);
  const double k = size.height_m / 1.70;
  const double stride = Between(dice, -0.16, 0.16) * k;
  for (const double side : {-1.0, 1.0}) {
    const double y = side * 0.10 * k, x = side * stride;
    shop.solid.Box(shoe, Shift(x + 0.05 * k, y, 0), {0.27 * k, 0.10 * k, 0.08 * k});
    const std::array leg{LevelRing(x, y, 0.06 * k, 0.055 * k, 0.055 * k),
                         LevelRing(x * 0.6, y, 0.48 * k, 0.065 * k, 0.062 * k),
                         LevelRing(0, y * 0.95, 0.86 * k, 0.092 * k, 0.09 * k)};
    shop.solid.Loft(trousers, leg, 12);
    // Arms swing against the legs.
    const Vector3d shoulder(0, side * 0.205 * k, 1.38 * k);
    const Vector3d elbow(-x * 0.5, side * 0.26 * k, 1.10 * k);
    const Vector3d hand(-x * 0.8 + 0.06 * k, side * 0.265 * k, 0.84 * k);
    shop.solid.Tube(cloth, shoulder, elbow, 0.055 * k, 0.046 * k, 10);
    shop.solid.Tube(cloth, elbow, hand, 0.046 * k, 0.036 * k, 10);
    shop.solid.Tube(skin, hand, hand - Vector3d(0, 0, 0.11 * k), 0.036 * k, 0.025 * k, 8);
  }
  const std::array torso{LevelRing(0, 0, 0.82 * k, 0.105 * k, 0.165 * k),
                         LevelRing(0, 0, 0.95 * k, 0.115 * k, 0.170 * k),
                         LevelRing(0, 0, 1.10 * k, 0.105 * k, 0.155 * k),
                         LevelRing(0, 0, 1.32 * k, 0.115 * k, 0.195 * k),
                         LevelRing(0, 0, 1.42 * k, 0.085 * k, 0.180 * k),
                         LevelRing(0, 0, 1.46 * k, 0.050 * k, 0.070 * k)};
  shop.solid.Loft(cloth, torso, 20);
  shop.solid.Tube(skin, Vector3d(0, 0, 1.44 * k), Vector3d(0.01 * k, 0, 1.53 * k), 0.05 * k,
                  0.048 * k, 12);
  std::vector<Ring> head, cap;
  for (int i = 0; i <= 8; ++i) {
    const double t = core::kPi * (0.06 + 0.88 * i / 8.0);
    const double r = std::sin(t), z = 1.59 * k - 0.115 * k * std::cos(t);
    head.push_back(LevelRing(0.015 * k, 0, z, 0.095 * k * r, 0.076 * k * r));
    if (i >= 4)
      cap.push_back(LevelRing(-0.006 * k, 0, z + 0.012 * k, 0.095 * k * r, 0.084 * k * r));
  }
  shop.solid.Loft(skin, head, 14);
  shop.solid.Loft(hair, cap, 14);
}

Size SizeOf(const PropConfig& prop, Dice& dice) {
  struct Usual {
    std::array<double, 2> length, width, height;
  };
  const Usual usual = [&]() -> Usual {
    switch (prop.kind) {
      case PropKind::kCar:
        return {{3.9, 4.7}, {1.72, 1.84}, {1.40, 1.54}};
      case PropKind::kWagon:
        return {{4.6, 4.8}, {1.82, 1.90}, {1.94, 2.02}};
      case PropKind::kTruck:
        return {{6.0, 6.6}, {2.10, 2.22}, {2.80, 3.05}};
      case PropKind::kTree:
        return {{3.0, 5.0}, {3.0, 5.0}, {5.0, 8.0}};
      case PropKind::kPole:
        return {{0.4, 0.4}, {1.5, 1.8}, {10.0, 12.0}};
      case PropKind::kLamp:
        return {{1.2, 1.6}, {0.3, 0.3}, {5.5, 7.0}};
      case PropKind::kPerson:
        return {{0.4, 0.4}, {0.55, 0.6}, {1.55, 1.85}};
      case PropKind::kBox:
        return {{0.35, 0.9}, {0.30, 0.7}, {0.25, 0.8}};
      case PropKind::kCone:
        return {{0.36, 0.40}, {0.36, 0.40}, {0.68, 0.74}};
      case PropKind::kDrum:
        return {{0.57, 0.60}, {0.57, 0.60}, {0.86, 0.90}};
      case PropKind::kSign:
        return {{0.1, 0.1}, {0.6, 0.6}, {2.4, 2.9}};
      case PropKind::kPallet:
        return {{1.1, 1.2}, {1.0, 1.1}, {0.9, 1.7}};
    }
    return {{1, 1}, {1, 1}, {1, 1}};
  }();
  const auto draw = [&dice](const std::array<double, 2>& range) {
    return Between(dice, range[0], range[1]);
  };
  // Drawn always, so that naming one figure leaves the others as they are.
  const Size drawn{draw(usual.length), draw(usual.width), draw(usual.height)};
  return {prop.length_m.value_or(drawn.length_m), prop.width_m.value_or(drawn.width_m),
          prop.height_m.value_or(drawn.height_m)};
}

void BuildProp(Workshop& shop, const PropConfig& prop, const Size& size) {
  constexpr std::array<Rgb, 8> kPaints{{{0.72, 0.72, 0.71},
                                        {0.38, 0.39, 0.40},
                                        {0.035, 0.036, 0.04},
                                        {0.32, 0.03, 0.025},
                                        {0.03, 0.07, 0.20},
                                        {0.55, 0.54, 0.50},
                                        {0.08, 0.16, 0.14},
                                        {0.16, 0.17, 0.18}}};
  constexpr std::array<Rgb, 6> kBright{{{0.03, 0.12, 0.36},
                                        {0.40, 0.04, 0.03},
                                        {0.45, 0.32, 0.02},
                                        {0.05, 0.20, 0.08},
                                        {0.25, 0.25, 0.26},
                                        {0.10, 0.06, 0.15}}};
  const Rgb paint =
      kPaints[static_cast<std::size_t>(Pick(shop.dice, static_cast<int>(kPaints.size())))];
  const Rgb bright =
      kBright[static_cast<std::size_t>(Pick(shop.dice, static_cast<int>(kBright.size())))];
  switch (prop.kind) {
    case PropKind::kCar:
      return BuildCar(shop, size, prop.rgb.value_or(paint));
    case PropKind::kWagon:
      return BuildWagon(shop, size, prop.rgb.value_or(paint));
    case PropKind::kTruck:
      return BuildTruck(shop, size, prop.rgb.value_or(kBright[0]));
    case PropKind::kTree:
      return BuildTree(shop, size);
    case PropKind::kPole:
      return BuildPole(shop, size);
    case PropKind::kLamp:
      return BuildLamp(shop, size);
    case PropKind::kPerson:
      return BuildPerson(shop, size, prop.rgb.value_or(bright));
    case PropKind::kBox:
      return BuildBox(shop, size, prop.rgb.value_or(Rgb{0.42, 0.29, 0.16}));
    case PropKind::kCone:
      return BuildCone(shop, size);
    case PropKind::kDrum:
      return BuildDrum(shop, size, prop.rgb.value_or(bright));
    case PropKind::kSign:
      return BuildSign(shop, size, prop.rgb.value_or(Rgb{0.50, 0.02, 0.02}));
    case PropKind::kPallet:
      return BuildPallet(shop, size);
  }
}

}  // namespace kawara::sim
