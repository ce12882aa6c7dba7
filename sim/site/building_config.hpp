#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "sim/site/polygon.hpp"
#include "sim/site/thing_config.hpp"

namespace kawara::sim {

enum class RoofType : std::uint8_t { kFlat, kGable, kHip };
constexpr auto ConfigNames(RoofType) {
  using N = config::EnumName<RoofType>;
  return std::array{N{RoofType::kFlat, "flat"}, N{RoofType::kGable, "gable"},
                    N{RoofType::kHip, "hip"}};
}

struct RoofConfig {
  RoofType type = RoofType::kFlat;
  double rise_m = 1.5;   ///< ridge above the walls; of a flat roof: its parapet, may be 0
  double eaves_m = 0.5;  ///< how far it stands out over the walls
  SurfaceConfig surface{.pattern = Pattern::kConcrete};

  template <class V>
  void Visit(V& v) {
    v("type", type);
    v("rise_m", rise_m, config::Range{0.0, 20.0}, config::Optional{});
    v("eaves_m", eaves_m, config::Range{0.0, 3.0}, config::Optional{});
    v("surface", surface, config::Optional{});
    v.Require(type == RoofType::kFlat || rise_m >= 0.2, "rise_m", "at least 0.2 for this type");
  }
};

/// A grid of windows on every side that is long enough: as many columns as fit, one row a storey.
struct WindowsConfig {
  double width_m = 1.6;
  double height_m = 1.2;
  double sill_m = 0.9;       ///< above the storey's floor
  double spacing_m = 3.0;    ///< between centres, at least
  double recess_m = 0.12;    ///< panes behind the wall's surface
  std::vector<int> sides;    ///< which sides have windows; empty: all
  double blank_share = 0.0;  ///< of windows that are left out, by chance

  template <class V>
  void Visit(V& v) {
    v("width_m", width_m, config::Range{0.2, 10.0}, config::Optional{});
    v("height_m", height_m, config::Range{0.2, 10.0}, config::Optional{});
    v("sill_m", sill_m, config::Range{0.05, 10.0}, config::Optional{});
    v("spacing_m", spacing_m, config::Range{0.3, 100.0}, config::Optional{});
    v("recess_m", recess_m, config::Range{0.02, 0.5}, config::Optional{});
    v("sides", sides, config::Range{0, 63}, config::Optional{});
    v("blank_share", blank_share, config::Range{0.0, 1.0}, config::Optional{});
    v.Require(spacing_m >= width_m + 0.1, "spacing_m", "at least 0.1 m more than width_m");
  }
};

enum class DoorKind : std::uint8_t { kDoor, kShutter, kGlazed };
constexpr auto ConfigNames(DoorKind) {
  using N = config::EnumName<DoorKind>;
  return std::array{N{DoorKind::kDoor, "door"}, N{DoorKind::kShutter, "shutter"},
                    N{DoorKind::kGlazed, "glazed"}};
}

struct DoorConfig {
  int side = 0;
  double at_m = 0.0;  ///< its middle, along the side from its left end seen from outside
  double width_m = 0.9;
  double height_m = 2.1;
  DoorKind kind = DoorKind::kDoor;
  std::optional<Rgb> rgb;

  template <class V>
  void Visit(V& v) {
    v("side", side, config::Range{0, 63}, config::Optional{});
    v("at_m", at_m, config::Range{0.0, 500.0});
    v("width_m", width_m, config::Range{0.4, 30.0}, config::Optional{});
    v("height_m", height_m, config::Range{0.5, 15.0}, config::Optional{});
    v("kind", kind, config::Optional{});
    v("rgb", rgb, config::Range{0.0, 1.0});
  }
};

/// Sides: 0 front (where the heading points), 1 its left, 2 back, 3 right.
struct RectangleConfig {
  EastNorth centre_m{};
  std::array<double, 2> size_m{10.0, 8.0};  ///< along the heading, across
  double heading_deg = 0.0;

  template <class V>
  void Visit(V& v) {
    v("centre_m", centre_m, config::Range{-1000.0, 1000.0});
    v("size_m", size_m, config::Range{1.0, 500.0});
    v("heading_deg", heading_deg, config::Range{-360.0, 360.0}, config::Optional{});
  }
};

/// The disaster makes a heap of the building; walls lean on it. The building itself is then `gone`
/// and its heap ("NAME-rubble") is `new`, whatever `state` says.
struct CollapseConfig {
  double toward_deg = 0.0;  ///< true direction in which the heap slid
  double slide_m = 3.0;     ///< of the heap's middle from the building's
  int leaning_walls = 3;
  double height_share = 0.35;  ///< of the heap in the walls' height

  template <class V>
  void Visit(V& v) {
    v("toward_deg", toward_deg, config::Range{-360.0, 360.0}, config::Optional{});
    v("slide_m", slide_m, config::Range{0.0, 20.0}, config::Optional{});
    v("leaning_walls", leaning_walls, config::Range{0, 8}, config::Optional{});
    v("height_share", height_share, config::Range{0.1, 0.8}, config::Optional{});
  }
};

struct BuildingConfig : Standing {
  std::vector<EastNorth> footprint_m;  ///< simple polygon, counter-clockwise; side i starts at i
  std::optional<RectangleConfig> rectangle;
  double height_m = 6.0;  ///< of the walls
  int storeys = 2;
  double plinth_m = 0.4;  ///< height of the concrete band at the foot; 0: none
  SurfaceConfig wall{.pattern = Pattern::kConcrete};
  RoofConfig roof;
  std::optional<WindowsConfig> windows;
  std::vector<DoorConfig> doors;
  bool fittings = true;  ///< gutters, down-pipes, vents, air conditioners
  std::optional<CollapseConfig> collapse;

  template <class V>
  void Visit(V& v) {
    VisitStanding(v);
    v("footprint_m", footprint_m, config::Range{-1000.0, 1000.0}, config::Optional{});
    v("rectangle", rectangle);
    v("height_m", height_m, config::Range{1.0, 60.0});
    v("storeys", storeys, config::Range{1, 20}, config::Optional{});
    v("plinth_m", plinth_m, config::Range{0.0, 3.0}, config::Optional{});
    v("wall", wall, config::Optional{});
    v("roof", roof, config::Optional{});
    v("windows", windows);
    v("doors", doors, config::Optional{});
    v("fittings", fittings, config::Optional{});
    v("collapse", collapse);
    v.Require(rectangle.has_value() != !footprint_m.empty(), "footprint_m",
              "either footprint_m or rectangle, not both");
    v.Require(rectangle || IsSimplePolygon(footprint_m), "footprint_m",
              "3 points or more, counter-clockwise, no side crossing another");
    v.Require(rectangle || roof.type == RoofType::kFlat, "roof", "a flat roof over a polygon");
    v.Require(DoorsFit(), "doors", "each within its side and lower than the walls");
    v.Require(!windows || windows->sill_m + windows->height_m < height_m / storeys, "windows",
              "sill and height less than a storey");
  }

  /// Corners counter-clockwise; side i runs from corner i to the next.
  std::vector<EastNorth> Corners() const;

 private:
  bool DoorsFit() const;
};

}  // namespace kawara::sim
