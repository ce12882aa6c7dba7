#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/config/constraints.hpp"
#include "sim/site/scene.hpp"

/// What a site file says about single things. Positions are east and north [m] from the site's
/// origin; heights come from the terrain. Headings are true, clockwise from north.
namespace kawara::sim {

namespace config = core::config;

using EastNorth = std::array<double, 2>;  ///< [m]
using Rgb = std::array<double, 3>;        ///< linear reflectance, 0..1

/// When a thing stands there: what the GIS knows and what the disaster changed.
enum class Existence : std::uint8_t {
  kKnown,  ///< in the reference, there before and after
  kGone,   ///< in the reference, removed by the disaster
  kNew,    ///< there after the disaster only
};
constexpr auto ConfigNames(Existence) {
  return std::array{config::EnumName<Existence>{Existence::kKnown, "known"},
                    config::EnumName<Existence>{Existence::kGone, "gone"},
                    config::EnumName<Existence>{Existence::kNew, "new"}};
}

constexpr auto ConfigNames(Pattern) {
  using N = config::EnumName<Pattern>;
  return std::array{N{Pattern::kPlain, "plain"},       N{Pattern::kAsphalt, "asphalt"},
                    N{Pattern::kConcrete, "concrete"}, N{Pattern::kBrick, "brick"},
                    N{Pattern::kTiles, "tiles"},       N{Pattern::kCorrugated, "corrugated"},
                    N{Pattern::kGlass, "glass"},       N{Pattern::kWood, "wood"},
                    N{Pattern::kSoil, "soil"},         N{Pattern::kGrass, "grass"},
                    N{Pattern::kLeaves, "leaves"},     N{Pattern::kRubble, "rubble"},
                    N{Pattern::kCloth, "cloth"}};
}

/// Looks of a surface; what is left out is usual for the pattern.
struct SurfaceConfig {
  Pattern pattern = Pattern::kPlain;
  std::optional<Rgb> rgb{};
  std::optional<double> scale_m{};   ///< of the pattern's unit
  std::optional<double> contrast{};  ///< 0: as good as plain

  template <class V>
  void Visit(V& v) {
    v("pattern", pattern);
    v("rgb", rgb, config::Range{0.0, 1.0});
    v("scale_m", scale_m, config::Range{0.01, 100.0});
    v("contrast", contrast, config::Range{0.0, 2.0});
  }
};

/// Name and existence of every thing.
struct Standing {
  std::string name;  ///< empty: made by rule, "truck-1"
  Existence state = Existence::kKnown;
  std::optional<double> begin_s;  ///< comes and goes between passes; from the mission's start
  std::optional<double> end_s;

  template <class V>
  void VisitStanding(V& v) {
    v("name", name, config::Optional{});
    v("state", state, config::Optional{});
    v("begin_s", begin_s, config::Range{-1e6, 1e6});
    v("end_s", end_s, config::Range{-1e6, 1e6});
    v.Require(!begin_s || !end_s || *begin_s < *end_s, "end_s", "later than begin_s");
  }
};

/// Things of a known shape that stand on one spot.
enum class PropKind : std::uint8_t {
  kCar,
  kWagon,
  kTruck,
  kTree,
  kPole,
  kLamp,
  kPerson,
  kBox,
  kCone,
  kDrum,
  kSign,
  kPallet
};
constexpr auto ConfigNames(PropKind) {
  using N = config::EnumName<PropKind>;
  return std::array{
      N{PropKind::kCar, "car"},       N{PropKind::kWagon, "wagon"}, N{PropKind::kTruck, "truck"},
      N{PropKind::kTree, "tree"},     N{PropKind::kPole, "pole"},   N{PropKind::kLamp, "lamp"},
      N{PropKind::kPerson, "person"}, N{PropKind::kBox, "box"},     N{PropKind::kCone, "cone"},
      N{PropKind::kDrum, "drum"},     N{PropKind::kSign, "sign"},   N{PropKind::kPallet, "pallet"}};
}

struct PropConfig : Standing {
  PropKind kind = PropKind::kBox;
  EastNorth at_m{};
  double heading_deg = 0.0;
  std::optional<double> length_m;  ///< sizes left out are drawn within what is usual for the kind
  std::optional<double> width_m;
  std::optional<double> height_m;
  std::optional<Rgb> rgb;

  template <class V>
  void Visit(V& v) {
    v("kind", kind);
    VisitStanding(v);
    v("at_m", at_m, config::Range{-1000.0, 1000.0});
    v("heading_deg", heading_deg, config::Range{-360.0, 360.0}, config::Optional{});
    v("length_m", length_m, config::Range{0.05, 30.0});
    v("width_m", width_m, config::Range{0.05, 30.0});
    v("height_m", height_m, config::Range{0.05, 30.0});
    v("rgb", rgb, config::Range{0.0, 1.0});
  }
};

enum class FenceStyle : std::uint8_t { kBars, kBlocks, kPanels, kHedge };
constexpr auto ConfigNames(FenceStyle) {
  using N = config::EnumName<FenceStyle>;
  return std::array{N{FenceStyle::kBars, "bars"}, N{FenceStyle::kBlocks, "blocks"},
                    N{FenceStyle::kPanels, "panels"}, N{FenceStyle::kHedge, "hedge"}};
}

struct FenceConfig : Standing {
  std::vector<EastNorth> points_m;  ///< the line it follows
  double height_m = 1.8;
  FenceStyle style = FenceStyle::kBars;
  std::optional<Rgb> rgb;

  template <class V>
  void Visit(V& v) {
    VisitStanding(v);
    v("points_m", points_m, config::Range{-1000.0, 1000.0}, config::NotEmpty{});
    v("height_m", height_m, config::Range{0.3, 6.0}, config::Optional{});
    v("style", style, config::Optional{});
    v("rgb", rgb, config::Range{0.0, 1.0});
    v.Require(points_m.size() >= 2, "points_m", "at least 2 points");
  }
};

/// A heap of broken concrete, boards and splinters.
struct RubbleConfig : Standing {
  EastNorth at_m{};
  double heading_deg = 0.0;
  std::array<double, 2> size_m{6.0, 4.0};  ///< along the heading, across
  double height_m = 1.5;
  double pieces_per_m2 = 14.0;

  template <class V>
  void Visit(V& v) {
    VisitStanding(v);
    v("at_m", at_m, config::Range{-1000.0, 1000.0});
    v("heading_deg", heading_deg, config::Range{-360.0, 360.0}, config::Optional{});
    v("size_m", size_m, config::Range{0.5, 60.0});
    v("height_m", height_m, config::Range{0.1, 12.0});
    v("pieces_per_m2", pieces_per_m2, config::Range{0.1, 60.0}, config::Optional{});
  }
};

}  // namespace kawara::sim
