#include <algorithm>
#include <array>
#include <cmath>

#include "sim/site/shapes.hpp"

namespace kawara::sim {
namespace {

constexpr double kDoorRecess_m = 0.14;

enum class OpeningKind : std::uint8_t { kWindow, kDoor, kShutter, kGlazed };

/// A hole in a wall: x from the side's left end seen from outside, z over the floor.
struct Opening {
  double x0, x1, z0, z1;
  OpeningKind kind;
  double recess_m;
  std::uint32_t panel;  ///< material of a door's leaf or a shutter
};

struct WallColours {
  std::uint32_t wall, plinth, frame, sill, dark, pipe;
  std::array<std::uint32_t, 3> panes;  ///< dark rooms, curtains, blinds
};

WallColours Colours(Workshop& shop, const BuildingConfig& building) {
  Materials& m = shop.materials;
  Material curtain = UsualMaterial(Pattern::kGlass);
  curtain.base_rgb = {0.26F, 0.25F, 0.22F};
  curtain.second_rgb = {0.20F, 0.19F, 0.17F};
  Material blind = curtain;
  blind.base_rgb = {0.14F, 0.16F, 0.17F};
  blind.second_rgb = {0.10F, 0.12F, 0.13F};
  const bool bright = Chance(shop.dice, 0.5);
  return {m.Add(building.wall, shop.dice.Next()),
          m.Add(Pattern::kConcrete, {0.30, 0.29, 0.28}, shop.dice.Next()),
          bright ? m.Paint({0.60, 0.61, 0.61}, 0.06F) : m.Paint({0.10, 0.085, 0.075}, 0.06F),
          m.Paint({0.45, 0.45, 0.44}, 0.03F),
          m.Paint({0.05, 0.05, 0.05}, 0.0F),
          m.Paint({0.33, 0.32, 0.30}, 0.02F),
          {m.Add(UsualMaterial(Pattern::kGlass)), m.Add(curtain), m.Add(blind)}};
}

bool Overlap(const Opening& a, const Opening& b, double gap_m) {
  return a.x0 < b.x1 + gap_m && b.x0 < a.x1 + gap_m && a.z0 < b.z1 + gap_m && b.z0 < a.z1 + gap_m;
}

std::vector<Opening> DoorsOf(Workshop& shop, const BuildingConfig& building, int side) {
  std::vector<Opening> doors;
  for (const DoorConfig& door : building.doors) {
    if (door.side != side) continue;
    Opening o{door.at_m - door.width_m / 2,
              door.at_m + door.width_m / 2,
              0.02,
              door.height_m,
              OpeningKind::kDoor,
              kDoorRecess_m,
              0};
    if (door.kind == DoorKind::kShutter) {
      o.kind = OpeningKind::kShutter;
      Material m = UsualMaterial(Pattern::kCorrugated);
      const Rgb rgb = door.rgb.value_or(Rgb{0.46, 0.48, 0.47});
      for (std::size_t i = 0; i < 3; ++i) {
        m.base_rgb[i] = static_cast<float>(rgb[i]);
        m.second_rgb[i] = m.base_rgb[i] * 0.7F;
      }
      o.panel = shop.materials.Add(m);
    } else if (door.kind == DoorKind::kGlazed) {
      o.kind = OpeningKind::kGlazed;
    } else {
      o.panel = shop.materials.Paint(door.rgb.value_or(Rgb{0.22, 0.16, 0.11}), 0.03F);
    }
    doors.push_back(o);
  }
  return doors;
}

std::vector<Opening> WindowsOf(Workshop& shop, const BuildingConfig& building, int side,
                               double length_m, const std::vector<Opening>& doors) {
  std::vector<Opening> windows;
  if (!building.windows) return windows;
  const WindowsConfig& w = *building.windows;
  if (!w.sides.empty() && std::find(w.sides.begin(), w.sides.end(), side) == w.sides.end())
    return windows;
  constexpr double kCornerGap_m = 0.45;
  const double room = length_m - 2.0 * kCornerGap_m - w.width_m;
  if (room < 0) return windows;
  const int columns = 1 + static_cast<int>(room / w.spacing_m);
  const double storey_m = building.height_m / building.storeys;
  for (int row = 0; row < building.storeys; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double middle = length_m * (column + 0.5) / columns;
      const double z0 = row * storey_m + w.sill_m;
      const Opening o{middle - w.width_m / 2,
                      middle + w.width_m / 2,
                      z0,
                      z0 + w.height_m,
                      OpeningKind::kWindow,
                      w.recess_m,
                      0};
      const bool blocked = std::any_of(doors.begin(), doors.end(),
                                       [&o](const Opening& d) { return Overlap(o, d, 0.2); });
      const bool blank = Chance(shop.dice, w.blank_share);
      if (!blocked && !blank) windows.push_back(o);
    }
  }
  return windows;
}

void BuildPanes(Workshop& shop, const WallColours& colours, const Frame& wall, const Opening& o) {
  const double d = o.recess_m, bar = 0.05, y0 = d - 0.05, y1 = d - 0.002;
  const int fields = std::max(1, static_cast<int>(std::lround((o.x1 - o.x0) / 0.9)));
  const std::uint32_t pane = colours.panes[static_cast<std::size_t>(Pick(shop.dice, 3))];
  SolidBuilder& s = shop.solid;
  const auto at = [&wall](double x, double y, double z) -> Vector3d {
    return wall * Vector3d(x, y, z);
  };
  s.Quad(pane, at(o.x0, d, o.z0), at(o.x1, d, o.z0), at(o.x1, d, o.z1), at(o.x0, d, o.z1));
  s.BoxBetween(colours.frame, wall, {o.x0, y0, o.z0}, {o.x1, y1, o.z0 + bar});
  s.BoxBetween(colours.frame, wall, {o.x0, y0, o.z1 - bar}, {o.x1, y1, o.z1});
  for (int i = 0; i <= fields; ++i) {
    const double x = o.x0 + bar / 2 + (o.x1 - o.x0 - bar) * i / fields;
    s.BoxBetween(colours.frame, wall, {x - bar / 2, y0 + 0.002, o.z0 + bar},
                 {x + bar / 2, y1, o.z1 - bar});
  }
  if (o.z1 - o.z0 > 1.9 && o.kind == OpeningKind::kWindow)
    s.BoxBetween(colours.frame, wall, {o.x0 + bar, y0 + 0.004, (o.z0 + o.z1) / 2 - bar / 2},
                 {o.x1 - bar, y1, (o.z0 + o.z1) / 2 + bar / 2});
  if (o.kind == OpeningKind::kWindow)
    s.BoxBetween(colours.sill, wall, {o.x0 - 0.06, -0.05, o.z0 - 0.05}, {o.x1 + 0.06, 0.02, o.z0});
}

void BuildDoorLeaf(Workshop& shop, const WallColours& colours, const Frame& wall,
                   const Opening& o) {
  SolidBuilder& s = shop.solid;
  const double d = o.recess_m;
  const auto at = [&wall](double x, double y, double z) -> Vector3d {
    return wall * Vector3d(x, y, z);
  };
  s.Quad(o.panel, at(o.x0, d, o.z0), at(o.x1, d, o.z0), at(o.x1, d, o.z1), at(o.x0, d, o.z1));
  if (o.kind == OpeningKind::kShutter) {
    for (const double x : {o.x0, o.x1 - 0.09})  // guide rails
      s.BoxBetween(colours.pipe, wall, {x, d - 0.06, o.z0}, {x + 0.09, d - 0.002, o.z1});
    s.BoxBetween(colours.pipe, wall, {o.x0 - 0.1, -0.22, o.z1}, {o.x1 + 0.1, 0.02, o.z1 + 0.42});
    s.BoxBetween(colours.dark, wall, {o.x0 + 0.09, d - 0.04, o.z0}, {o.x1 - 0.09, d, o.z0 + 0.07});
    return;
  }
  constexpr double kBar_m = 0.06;
  s.BoxBetween(colours.frame, wall, {o.x0, d - 0.04, o.z0}, {o.x0 + kBar_m, d - 0.002, o.z1});
  s.BoxBetween(colours.frame, wall, {o.x1 - kBar_m, d - 0.04, o.z0}, {o.x1, d - 0.002, o.z1});
  s.BoxBetween(colours.frame, wall, {o.x0, d - 0.042, o.z1 - kBar_m}, {o.x1, d - 0.002, o.z1});
  s.BoxBetween(colours.dark, wall, {o.x1 - 0.17, d - 0.07, o.z0 + 0.9},
               {o.x1 - 0.13, d - 0.002, o.z0 + 1.15});
  s.BoxBetween(colours.plinth, wall, {o.x0 - 0.15, -0.45, -0.3}, {o.x1 + 0.15, 0.0, 0.02});
  if (o.x1 - o.x0 < 1.6)  // porch roof
    s.BoxBetween(colours.sill, wall, {o.x0 - 0.35, -0.85, o.z1 + 0.25},
                 {o.x1 + 0.35, 0.01, o.z1 + 0.33});
}

void BuildReveal(SolidBuilder& s, std::uint32_t material, const Frame& wall, const Opening& o) {
  const auto at = [&wall](double x, double y, double z) -> Vector3d {
    return wall * Vector3d(x, y, z);
  };
  const double d = o.recess_m;
  s.Quad(material, at(o.x0, 0, o.z0), at(o.x1, 0, o.z0), at(o.x1, d, o.z0), at(o.x0, d, o.z0));
  s.Quad(material, at(o.x0, d, o.z1), at(o.x1, d, o.z1), at(o.x1, 0, o.z1), at(o.x0, 0, o.z1));
  s.Quad(material, at(o.x0, 0, o.z0), at(o.x0, d, o.z0), at(o.x0, d, o.z1), at(o.x0, 0, o.z1));
  s.Quad(material, at(o.x1, d, o.z0), at(o.x1, 0, o.z0), at(o.x1, 0, o.z1), at(o.x1, d, o.z1));
}

std::vector<double> Cuts(std::vector<double> at) {
  std::sort(at.begin(), at.end());
  constexpr double kSame_m = 1e-6;
  at.erase(std::unique(at.begin(), at.end(), [](double a, double b) { return b - a < kSame_m; }),
           at.end());
  return at;
}

/// The wall around its openings, as a grid of rectangles.
void BuildWallFace(SolidBuilder& s, std::uint32_t material, const Frame& wall, double length_m,
                   double foot_m, double height_m, const std::vector<Opening>& openings) {
  std::vector<double> xs{0.0, length_m}, zs{foot_m, height_m};
  for (const Opening& o : openings) {
    xs.insert(xs.end(), {o.x0, o.x1});
    zs.insert(zs.end(), {o.z0, o.z1});
  }
  xs = Cuts(xs);
  zs = Cuts(zs);
  for (std::size_t k = 0; k + 1 < zs.size(); ++k) {
    const double z = (zs[k] + zs[k + 1]) / 2;
    // Cells next to each other in a row become one rectangle.
    std::size_t begin = 0;
    for (std::size_t i = 0; i + 1 < xs.size(); ++i) {
      const double x = (xs[i] + xs[i + 1]) / 2;
      const bool open = std::any_of(openings.begin(), openings.end(), [&](const Opening& o) {
        return x > o.x0 && x < o.x1 && z > o.z0 && z < o.z1;
      });
      const auto flush = [&](std::size_t end) {
        if (end <= begin) return;
        s.Quad(material, wall * Vector3d(xs[begin], 0, zs[k]), wall * Vector3d(xs[end], 0, zs[k]),
               wall * Vector3d(xs[end], 0, zs[k + 1]), wall * Vector3d(xs[begin], 0, zs[k + 1]));
      };
      if (open) {
        flush(i);
        begin = i + 1;
      } else if (i + 2 == xs.size()) {
        flush(i + 1);
      }
    }
  }
}

/// The band at the foot, left out before doors.
void BuildPlinth(SolidBuilder& s, std::uint32_t material, const Frame& wall, double length_m,
                 double foot_m, double top_m, const std::vector<Opening>& openings) {
  std::vector<std::array<double, 2>> gaps;
  for (const Opening& o : openings)
    if (o.z0 < top_m) gaps.push_back({o.x0 - 0.02, o.x1 + 0.02});
  std::sort(gaps.begin(), gaps.end());
  double x = -0.03;
  gaps.push_back({length_m + 0.03, length_m + 0.03});
  for (const auto& [begin, end] : gaps) {
    if (begin - x > 0.05) s.BoxBetween(material, wall, {x, -0.03, foot_m}, {begin, 0.03, top_m});
    x = std::max(x, end);
  }
}

void BuildFittings(Workshop& shop, const WallColours& colours, const Frame& wall, double length_m,
                   double height_m, std::vector<Opening> taken) {
  SolidBuilder& s = shop.solid;
  const auto pipe = [&](double x) {
    s.Tube(colours.pipe, wall * Vector3d(x, -0.08, -0.2),
           wall * Vector3d(x, -0.08, height_m - 0.02), 0.045, 0.045, 10);
    for (double z = 0.5; z < height_m; z += 1.4)
      s.BoxBetween(colours.dark, wall, {x - 0.06, -0.09, z}, {x + 0.06, 0.0, z + 0.035});
  };
  const auto free = [&](double x, double half, double z0, double z1) {
    const Opening probe{x - half, x + half, z0, z1, OpeningKind::kWindow, 0, 0};
    const bool clear = std::none_of(taken.begin(), taken.end(),
                                    [&](const Opening& o) { return Overlap(probe, o, 0.08); });
    if (clear) taken.push_back(probe);
    return clear;
  };
  pipe(0.22);
  if (length_m > 14.0 && free(length_m / 2, 0.1, 0, height_m)) pipe(length_m / 2);
  const int tries = static_cast<int>(length_m / 5.0) + 1;
  for (int i = 0; i < tries; ++i) {
    const double x = Between(shop.dice, 0.8, std::max(0.9, length_m - 0.8));
    const double kind = shop.dice.Uniform();
    if (kind < 0.4 && free(x, 0.45, 0.0, 0.75)) {  // air conditioner on the ground
      s.BoxBetween(colours.sill, wall, {x - 0.40, -0.42, 0.08}, {x + 0.40, -0.10, 0.68});
      s.BoxBetween(colours.dark, wall, {x - 0.30, -0.425, 0.16}, {x + 0.12, -0.42, 0.60});
    } else if (kind < 0.75 && free(x, 0.2, height_m - 1.0, height_m - 0.5)) {  // vent
      s.BoxBetween(colours.sill, wall, {x - 0.18, -0.12, height_m - 0.95},
                   {x + 0.18, 0.0, height_m - 0.6});
    } else if (free(x, 0.22, 1.0, height_m)) {  // meter
      s.BoxBetween(colours.pipe, wall, {x - 0.15, -0.12, 1.1}, {x + 0.15, 0.0, 1.5});
      s.BoxBetween(colours.pipe, wall, {x - 0.015, -0.05, 1.5},
                   {x + 0.015, -0.01, height_m - 0.05});
    }
  }
}

}  // namespace

void BuildBuilding(Workshop& shop, const BuildingConfig& building,
                   const std::vector<Vector2d>& corners, double foot_m) {
  const WallColours colours = Colours(shop, building);
  SolidBuilder& s = shop.solid;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector2d along = corners[(i + 1) % corners.size()] - corners[i];
    const double length_m = along.norm();
    const Frame wall =
        Shift(corners[i].x(), corners[i].y(), 0) * TurnZ(std::atan2(along.y(), along.x()));
    std::vector<Opening> openings = DoorsOf(shop, building, static_cast<int>(i));
    const std::vector<Opening> windows =
        WindowsOf(shop, building, static_cast<int>(i), length_m, openings);
    openings.insert(openings.end(), windows.begin(), windows.end());
    BuildWallFace(s, colours.wall, wall, length_m, foot_m, building.height_m, openings);
    for (const Opening& o : openings) {
      BuildReveal(s, o.kind == OpeningKind::kWindow ? colours.wall : colours.sill, wall, o);
      if (o.kind == OpeningKind::kWindow || o.kind == OpeningKind::kGlazed) {
        BuildPanes(shop, colours, wall, o);
      } else {
        BuildDoorLeaf(shop, colours, wall, o);
      }
    }
    if (building.plinth_m > 0)
      BuildPlinth(s, colours.plinth, wall, length_m, foot_m, building.plinth_m, openings);
    if (building.fittings)
      BuildFittings(shop, colours, wall, length_m, building.height_m, openings);
  }
  const auto cap = [&](double z, bool up) {
    for (const auto& t : Triangulate(corners)) {
      const auto at = [&](std::uint32_t k) { return Vector3d(corners[k].x(), corners[k].y(), z); };
      if (up) {
        s.Triangle(colours.wall, at(t[0]), at(t[1]), at(t[2]));
      } else {
        s.Triangle(colours.wall, at(t[2]), at(t[1]), at(t[0]));
      }
    }
  };
  cap(building.height_m, true);
  cap(foot_m, false);
  BuildRoof(shop, building, colours.wall, corners);
}

}  // namespace kawara::sim
