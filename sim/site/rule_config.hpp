#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "sim/site/polygon.hpp"
#include "sim/site/thing_config.hpp"

/// Rules by which a site fills itself: rows of things along a line, things scattered over an area.
namespace kawara::sim {

/// Dwelling houses made by rule; drawn evenly between the two figures.
struct HouseRuleConfig {
  std::array<double, 2> frontage_m{7.0, 10.0};
  std::array<double, 2> depth_m{7.0, 9.0};
  std::array<int, 2> storeys{1, 2};

  template <class V>
  void Visit(V& v) {
    v("frontage_m", frontage_m, config::Range{4.0, 40.0}, config::Optional{});
    v("depth_m", depth_m, config::Range{4.0, 40.0}, config::Optional{});
    v("storeys", storeys, config::Range{1, 4}, config::Optional{});
    v.Require(frontage_m[0] <= frontage_m[1], "frontage_m", "the smaller figure first");
    v.Require(depth_m[0] <= depth_m[1], "depth_m", "the smaller figure first");
    v.Require(storeys[0] <= storeys[1], "storeys", "the smaller figure first");
  }
};

/// Either things of one kind, or houses.
struct RowConfig : Standing {
  std::optional<PropKind> kind;
  std::optional<HouseRuleConfig> houses;
  EastNorth from_m{};
  EastNorth to_m{};
  double spacing_m = 10.0;
  double jitter_m = 0.0;              ///< each thing is off its place by up to this, both ways
  std::optional<double> heading_deg;  ///< left out: along the line
  double heading_jitter_deg = 0.0;
  double skip_share = 0.0;  ///< of places that stay empty, by chance

  template <class V>
  void Visit(V& v) {
    VisitStanding(v);
    v("kind", kind);
    v("houses", houses);
    v("from_m", from_m, config::Range{-1000.0, 1000.0});
    v("to_m", to_m, config::Range{-1000.0, 1000.0});
    v("spacing_m", spacing_m, config::Range{0.3, 500.0});
    v("jitter_m", jitter_m, config::Range{0.0, 20.0}, config::Optional{});
    v("heading_deg", heading_deg, config::Range{-360.0, 360.0});
    v("heading_jitter_deg", heading_jitter_deg, config::Range{0.0, 180.0}, config::Optional{});
    v("skip_share", skip_share, config::Range{0.0, 1.0}, config::Optional{});
    v.Require(kind.has_value() != houses.has_value(), "kind", "either kind or houses");
    v.Require(from_m != to_m, "to_m", "another place than from_m");
  }
};

/// Things of some kinds anywhere in an area, clear of what stands there already.
struct ScatterConfig : Standing {
  std::vector<PropKind> kinds;
  std::vector<EastNorth> area_m;  ///< simple polygon, counter-clockwise
  double per_100_m2 = 1.0;
  double clearance_m = 0.3;       ///< from other things
  double road_clearance_m = 0.0;  ///< from the road's middle
  double path_clearance_m = 1.2;  ///< from the vehicle's way

  template <class V>
  void Visit(V& v) {
    VisitStanding(v);
    v("kinds", kinds, config::NotEmpty{});
    v("area_m", area_m, config::Range{-1000.0, 1000.0});
    v("per_100_m2", per_100_m2, config::Range{0.0, 200.0});
    v("clearance_m", clearance_m, config::Range{0.0, 20.0}, config::Optional{});
    v("road_clearance_m", road_clearance_m, config::Range{0.0, 100.0}, config::Optional{});
    v("path_clearance_m", path_clearance_m, config::Range{0.0, 100.0}, config::Optional{});
    v.Require(IsSimplePolygon(area_m), "area_m",
              "3 points or more, counter-clockwise, no side crossing another");
  }
};

}  // namespace kawara::sim
