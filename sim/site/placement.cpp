#include "sim/site/placement.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "sim/site/seeds.hpp"
#include "sim/site/shapes.hpp"

namespace kawara::sim {
namespace {

using Eigen::Vector2d;

struct KindTraits {
  const char* name;
  ObjectClass cls;
  double radius_m;  ///< of the ground it takes, for scattering
};

KindTraits TraitsOf(PropKind kind) {
  switch (kind) {
    case PropKind::kCar:
      return {"car", ObjectClass::kCar, 2.6};
    case PropKind::kWagon:
      return {"wagon", ObjectClass::kCar, 2.8};
    case PropKind::kTruck:
      return {"truck", ObjectClass::kTruck, 3.5};
    case PropKind::kTree:
      return {"tree", ObjectClass::kTree, 1.5};
    case PropKind::kPole:
      return {"pole", ObjectClass::kPole, 0.3};
    case PropKind::kLamp:
      return {"lamp", ObjectClass::kPole, 0.3};
    case PropKind::kPerson:
      return {"person", ObjectClass::kPerson, 0.4};
    case PropKind::kBox:
      return {"box", ObjectClass::kClutter, 0.5};
    case PropKind::kCone:
      return {"cone", ObjectClass::kClutter, 0.3};
    case PropKind::kDrum:
      return {"drum", ObjectClass::kClutter, 0.4};
    case PropKind::kSign:
      return {"sign", ObjectClass::kPole, 0.3};
    case PropKind::kPallet:
      return {"pallet", ObjectClass::kClutter, 0.8};
  }
  return {"thing", ObjectClass::kClutter, 0.5};
}

Vector2d ToVector(const EastNorth& p) { return {p[0], p[1]}; }

/// Collects things: numbers them, names the nameless, gives each its chance.
class Register {
 public:
  Register(const SiteConfig& site, std::uint32_t first_id) : site_(site), next_id_(first_id) {}

  template <class What>
  Placed& Add(const Standing& standing, const std::string& kind, ObjectClass cls,
              const Vector2d& at_m, double heading_rad, What what) {
    Placed placed;
    placed.id = next_id_++;
    placed.name = standing.name.empty() ? FreshName(kind) : standing.name;
    placed.cls = cls;
    placed.state = standing.state;
    placed.begin_s = standing.begin_s;
    placed.end_s = standing.end_s;
    placed.seed = SeedFor(site_.seed, placed.name);
    placed.at_m = at_m;
    placed.heading_rad = heading_rad;
    placed.what = std::move(what);
    things_.push_back(std::move(placed));
    return things_.back();
  }

  void AddProp(const PropConfig& prop) {
    const KindTraits traits = TraitsOf(prop.kind);
    Add(prop, traits.name, traits.cls, ToVector(prop.at_m), prop.heading_deg * core::kRadFromDeg,
        prop);
  }

  void AddBuilding(BuildingConfig building) {
    const std::vector<Vector2d> corners = ToVectors(building.Corners());
    Vector2d middle = Vector2d::Zero();
    for (const Vector2d& corner : corners) middle += corner / static_cast<double>(corners.size());
    double heading = building.rectangle ? building.rectangle->heading_deg * core::kRadFromDeg
                                        : HeadingOfLongestSide(corners);
    if (building.collapse) building.state = Existence::kGone;
    const std::string name =
        Add(building, "building", ObjectClass::kBuilding, middle, heading, building).name;
    if (!building.collapse) return;
    const CollapseConfig& collapse = *building.collapse;
    const double toward = collapse.toward_deg * core::kRadFromDeg;
    const Vector2d way(std::sin(toward), std::cos(toward));
    double reach = 0.0, across = 0.0;
    for (const Vector2d& corner : corners) {
      reach = std::max(reach, std::abs(way.dot(corner - middle)));
      across = std::max(
          across, std::abs(way.x() * (corner - middle).y() - way.y() * (corner - middle).x()));
    }
    RuinConfig ruin;
    ruin.building = building;
    ruin.heap.name = name + "-rubble";
    ruin.heap.state = Existence::kNew;
    ruin.heap.begin_s = building.begin_s;
    ruin.heap.end_s = building.end_s;
    ruin.heap.at_m = {middle.x() + way.x() * collapse.slide_m,
                      middle.y() + way.y() * collapse.slide_m};
    ruin.heap.heading_deg = collapse.toward_deg;
    ruin.heap.size_m = {2.0 * reach + 0.6 * collapse.slide_m, 2.0 * across + 1.0};
    ruin.heap.height_m = building.height_m * collapse.height_share;
    Add(ruin.heap, "rubble", ObjectClass::kRubble, ToVector(ruin.heap.at_m), toward, ruin);
  }

  std::vector<Placed>& things() { return things_; }

 private:
  static double HeadingOfLongestSide(const std::vector<Vector2d>& corners) {
    Vector2d longest = Vector2d::Zero();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vector2d side = corners[(i + 1) % corners.size()] - corners[i];
      if (side.norm() > longest.norm()) longest = side;
    }
    return std::atan2(longest.x(), longest.y());
  }

  std::string FreshName(const std::string& kind) {
    return kind + "-" + std::to_string(++counts_[kind]);
  }

  const SiteConfig& site_;
  std::uint32_t next_id_;
  std::map<std::string, int> counts_;
  std::vector<Placed> things_;
};

void PlaceRow(Register& reg, const SiteConfig& site, const RowConfig& row, std::size_t index) {
  Dice dice = DiceFor(site.seed, "row-" + std::to_string(index) + row.name);
  const Vector2d from = ToVector(row.from_m);
  const Vector2d along = ToVector(row.to_m) - from;
  const Vector2d way = along.normalized();
  const int count = 1 + static_cast<int>(along.norm() / row.spacing_m + 1e-9);
  for (int i = 0; i < count; ++i) {
    const Vector2d off(Between(dice, -row.jitter_m, row.jitter_m),
                       Between(dice, -row.jitter_m, row.jitter_m));
    const double turn = Between(dice, -row.heading_jitter_deg, row.heading_jitter_deg);
    const bool skipped = Chance(dice, row.skip_share);
    const std::uint64_t seed = dice.Next();
    if (skipped) continue;
    const Vector2d at = from + way * (row.spacing_m * i) + off;
    const double heading_deg =
        row.heading_deg.value_or(std::atan2(way.x(), way.y()) * core::kDegFromRad) + turn;
    Standing standing = row;
    if (!row.name.empty()) standing.name = row.name + "-" + std::to_string(i + 1);
    if (row.kind) {
      PropConfig prop;
      static_cast<Standing&>(prop) = standing;
      prop.kind = *row.kind;
      prop.at_m = {at.x(), at.y()};
      prop.heading_deg = heading_deg;
      reg.AddProp(prop);
    } else {
      BuildingConfig house = MakeHouse(*row.houses, {at.x(), at.y()}, heading_deg, seed);
      static_cast<Standing&>(house) = standing;
      reg.AddBuilding(house);
    }
  }
}

/// What is taken already.
class Occupied {
 public:
  Occupied(const SiteConfig& site, const Terrain& terrain, const std::vector<Placed>& things)
      : site_(site), terrain_(terrain) {
    for (const Placed& thing : things) Take(thing);
  }
  void Take(const Placed& thing) {
    if (const auto* building = std::get_if<BuildingConfig>(&thing.what)) {
      footprints_.push_back(ToVectors(building->Corners()));
    } else if (const auto* heap = std::get_if<RubbleConfig>(&thing.what)) {
      TakeCircle(thing.at_m, std::max(heap->size_m[0], heap->size_m[1]) / 2.0);
    } else if (const auto* fence = std::get_if<FenceConfig>(&thing.what)) {
      fences_.push_back(ToVectors(fence->points_m));
    } else if (const auto* prop = std::get_if<PropConfig>(&thing.what)) {
      TakeCircle(thing.at_m, TraitsOf(prop->kind).radius_m);
    } else if (const auto* ruin = std::get_if<RuinConfig>(&thing.what)) {
      TakeCircle(thing.at_m, std::max(ruin->heap.size_m[0], ruin->heap.size_m[1]) / 2.0);
    }
  }
  bool Free(const Vector2d& at, double radius_m, const ScatterConfig& rule) const {
    const double room = radius_m + rule.clearance_m;
    for (const auto& [centre, radius] : circles_)
      if ((centre - at).norm() < radius + room) return false;
    for (const auto& footprint : footprints_)
      if (DistanceTo(footprint, at) < room) return false;
    for (const auto& line : fences_)
      for (std::size_t i = 0; i + 1 < line.size(); ++i)
        if (DistanceToSegment(at, line[i], line[i + 1]) < room) return false;
    const auto& path = site_.path.points;
    for (std::size_t i = 0; i + 1 < path.size(); ++i)
      if (DistanceToSegment(at, ToVector(path[i].at_m), ToVector(path[i + 1].at_m)) <
          rule.path_clearance_m + radius_m)
        return false;
    if (rule.road_clearance_m > 0) {
      const auto& road = terrain_.road();
      for (std::size_t i = 0; i + 1 < road.size(); ++i)
        if (DistanceToSegment(at, road[i].middle_m, road[i + 1].middle_m) <
            rule.road_clearance_m + radius_m)
          return false;
    }
    return true;
  }

 private:
  void TakeCircle(const Vector2d& at, double radius_m) { circles_.emplace_back(at, radius_m); }
  const SiteConfig& site_;
  const Terrain& terrain_;
  std::vector<std::pair<Vector2d, double>> circles_;
  std::vector<std::vector<Vector2d>> footprints_;
  std::vector<std::vector<Vector2d>> fences_;
};

void Scatter(Register& reg, Occupied& occupied, const SiteConfig& site, const ScatterConfig& rule,
             std::size_t index) {
  Dice dice = DiceFor(site.seed, "scatter-" + std::to_string(index) + rule.name);
  const std::vector<Vector2d> area = ToVectors(rule.area_m);
  Vector2d low = area[0], high = area[0];
  for (const Vector2d& p : area) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const double wanted = SignedArea(area) / 100.0 * rule.per_100_m2;
  const int count = static_cast<int>(wanted) + (Chance(dice, wanted - std::floor(wanted)) ? 1 : 0);
  constexpr int kTries = 30;  // then the area is as good as full
  for (int i = 0; i < count; ++i) {
    const PropKind kind =
        rule.kinds[static_cast<std::size_t>(Pick(dice, static_cast<int>(rule.kinds.size())))];
    for (int attempt = 0; attempt < kTries; ++attempt) {
      const Vector2d at(Between(dice, low.x(), high.x()), Between(dice, low.y(), high.y()));
      if (!Contains(area, at) || !occupied.Free(at, TraitsOf(kind).radius_m, rule)) continue;
      PropConfig prop;
      static_cast<Standing&>(prop) = rule;
      if (!rule.name.empty()) prop.name = rule.name + "-" + std::to_string(i + 1);
      prop.kind = kind;
      prop.at_m = {at.x(), at.y()};
      prop.heading_deg = Between(dice, 0.0, 360.0);
      reg.AddProp(prop);
      occupied.Take(reg.things().back());
      break;
    }
  }
}

}  // namespace

std::vector<Placed> PlaceThings(const SiteConfig& site, const Terrain& terrain,
                                std::uint32_t first_id) {
  Register reg(site, first_id);
  for (const BuildingConfig& building : site.buildings) reg.AddBuilding(building);
  for (const FenceConfig& fence : site.fences) {
    const Vector2d at = ToVector(fence.points_m[0]);
    const Vector2d along = ToVector(fence.points_m[1]) - at;
    reg.Add(fence, "fence", ObjectClass::kFence, at, std::atan2(along.x(), along.y()), fence);
  }
  for (const RubbleConfig& heap : site.rubble)
    reg.Add(heap, "rubble", ObjectClass::kRubble, ToVector(heap.at_m),
            heap.heading_deg * core::kRadFromDeg, heap);
  for (const PropConfig& prop : site.things) reg.AddProp(prop);
  for (std::size_t i = 0; i < site.rows.size(); ++i) PlaceRow(reg, site, site.rows[i], i);
  Occupied occupied(site, terrain, reg.things());
  for (std::size_t i = 0; i < site.scatter.size(); ++i)
    Scatter(reg, occupied, site, site.scatter[i], i);
  return std::move(reg.things());
}

}  // namespace kawara::sim
