#include "sim/site/scene_builder.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <variant>

#include "sim/site/placement.hpp"
#include "sim/site/shapes.hpp"

namespace kawara::sim {
namespace {

constexpr std::uint32_t kGroundId = 1;
constexpr std::uint32_t kKerbLeftId = 2;
constexpr std::uint32_t kKerbRightId = 3;
constexpr std::uint32_t kFirstThingId = 4;

void AddGround(Scene& scene, const SiteConfig& site, const Terrain& terrain) {
  Materials materials(scene);
  const auto seed = [&site](const char* what) { return SeedFor(site.seed, what); };
  const std::map<GroundPart, std::uint32_t> material{
      {GroundPart::kLand, materials.Add(site.terrain.surface, seed("land"))},
      {GroundPart::kRoad, materials.Add(site.road.surface, seed("asphalt"))},
      {GroundPart::kMarking, materials.Add(Pattern::kPlain, {0.62, 0.62, 0.60}, seed("marking"))},
      {GroundPart::kKerbLeft, materials.Add(Pattern::kConcrete, {0.44, 0.43, 0.41}, seed("kerb"))},
      {GroundPart::kKerbRight, materials.Add(Pattern::kConcrete, {0.44, 0.43, 0.41}, seed("kerb"))},
      {GroundPart::kPavement, materials.Add(site.road.pavement, seed("pavement"))}};
  std::map<GroundPart, Mesh> meshes;
  for (const Terrain::Triangle& t : terrain.triangles()) {
    Mesh& mesh = meshes[t.part];
    const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
    for (const Eigen::Vector3f& corner : t.corners_m) {
      mesh.vertices_m.push_back(corner);
      mesh.uv_m.emplace_back(corner.x(), corner.y());
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  for (auto& [part, mesh] : meshes) {
    mesh.material = material.at(part);
    mesh.object = part == GroundPart::kKerbLeft    ? kKerbLeftId
                  : part == GroundPart::kKerbRight ? kKerbRightId
                                                   : kGroundId;
    scene.meshes.push_back(std::move(mesh));
  }
  const Eigen::Vector2d left = terrain.road()[terrain.road().size() / 2].left;
  const double heading = std::atan2(left.y(), -left.x());
  const auto add = [&](std::uint32_t id, const char* name, ObjectClass cls) {
    scene.objects.push_back({id, name, cls, BoxAround(scene, id, heading), true, {}, {}});
  };
  add(kGroundId, "ground", ObjectClass::kGround);
  if (!meshes.contains(GroundPart::kKerbLeft)) return;
  add(kKerbLeftId, "kerb-left", ObjectClass::kKerb);
  add(kKerbRightId, "kerb-right", ObjectClass::kKerb);
}

/// Builds one thing into the scene, standing on the terrain.
class ThingBuilder {
 public:
  ThingBuilder(Scene& scene, const Terrain& terrain, const Placed& placed)
      : scene_(scene), terrain_(terrain), placed_(placed), dice_(placed.seed), materials_(scene) {}

  void operator()(const PropConfig& prop) {
    const Size size = SizeOf(prop, dice_);
    SolidBuilder solid(OnGround(prop.kind, size), placed_.id);
    Workshop shop{solid, materials_, dice_};
    BuildProp(shop, prop, size);
    solid.AppendTo(scene_);
  }
  void operator()(const BuildingConfig& building) {
    const std::vector<Vector2d> corners = ToVectors(building.Corners());
    const auto [low, high] = terrain_.HeightRange(corners);
    const Frame frame =
        StandingFrame(placed_.at_m.x(), placed_.at_m.y(), high, placed_.heading_rad);
    std::vector<Vector2d> local;
    for (const Vector2d& corner : corners)
      local.push_back((frame.inverse() * Vector3d(corner.x(), corner.y(), high)).head<2>());
    constexpr double kFoundation_m = 0.3;
    SolidBuilder solid(frame, placed_.id);
    Workshop shop{solid, materials_, dice_};
    BuildBuilding(shop, building, local, low - high - kFoundation_m);
    solid.AppendTo(scene_);
  }
  void operator()(const FenceConfig& fence) {
    // Posts follow the ground: legs no longer than this, each straight.
    constexpr double kLeg_m = 8.0;
    const std::vector<Vector2d> line = ToVectors(fence.points_m);
    std::vector<Vector3d> on_ground;
    const auto stand = [&](const Vector2d& p) {
      on_ground.emplace_back(p.x(), p.y(), terrain_.GroundHeight(p.x(), p.y()));
    };
    stand(line[0]);
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      const Vector2d along = line[i + 1] - line[i];
      const int legs = std::max(1, static_cast<int>(std::ceil(along.norm() / kLeg_m)));
      for (int k = 1; k <= legs; ++k) stand(line[i] + along * k / legs);
    }
    SolidBuilder solid(Frame::Identity(), placed_.id);
    Workshop shop{solid, materials_, dice_};
    BuildFence(shop, fence, on_ground);
    solid.AppendTo(scene_);
  }
  void operator()(const RubbleConfig& heap) {
    SolidBuilder solid(Upright(), placed_.id);
    Workshop shop{solid, materials_, dice_};
    BuildRubble(shop, heap, Ground());
    solid.AppendTo(scene_);
  }
  void operator()(const RuinConfig& ruin) {
    SolidBuilder solid(Upright(), placed_.id);
    Workshop shop{solid, materials_, dice_};
    BuildRuin(shop, ruin, Ground());
    solid.AppendTo(scene_);
  }

 private:
  double GroundAt(const Vector2d& p) const { return terrain_.GroundHeight(p.x(), p.y()); }
  Frame Upright() const {
    return StandingFrame(placed_.at_m.x(), placed_.at_m.y(), GroundAt(placed_.at_m),
                         placed_.heading_rad);
  }
  LocalGround Ground() const {
    return [this, frame = Upright()](double x, double y) {
      const Vector3d p = frame * Vector3d(x, y, 0);
      return GroundAt(p.head<2>()) - p.z();
    };
  }
  /// Vehicles stand on four wheels and tilt with the ground; all else stands upright.
  Frame OnGround(PropKind kind, const Size& size) const {
    const Frame upright = Upright();
    if (kind != PropKind::kCar && kind != PropKind::kWagon && kind != PropKind::kTruck)
      return upright;
    const auto height = [&](double x, double y) {
      const Vector3d p = upright * Vector3d(x, y, 0);
      return GroundAt(p.head<2>());
    };
    const double x = 0.3 * size.length_m, y = 0.42 * size.width_m;
    const double fl = height(x, y), fr = height(x, -y), rl = height(-x, y), rr = height(-x, -y);
    const double pitch = std::atan2((rl + rr - fl - fr) / 2.0, 2.0 * x);
    const double roll = std::atan2((fl + rl - fr - rr) / 2.0, 2.0 * y);
    const double mean = (fl + fr + rl + rr) / 4.0;
    return StandingFrame(placed_.at_m.x(), placed_.at_m.y(), mean, placed_.heading_rad) *
           TurnY(pitch) * TurnX(roll);
  }

  Scene& scene_;
  const Terrain& terrain_;
  const Placed& placed_;
  Dice dice_;
  Materials materials_;
};

/// From the box's bottom to the lowest ground under it; no more than its height.
double BuriedDepth(const UprightBox& box, const Terrain& terrain) {
  const Frame frame =
      StandingFrame(box.centre_enu_m.x(), box.centre_enu_m.y(), 0.0, box.heading_rad);
  std::vector<Vector2d> floor;
  for (const auto& [x, y] : {std::pair{0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}, {-0.5, -0.5}})
    floor.push_back((frame * Vector3d(x * box.size_m.x(), y * box.size_m.y(), 0)).head<2>());
  const double bottom_m = box.centre_enu_m.z() - box.size_m.z() / 2.0;
  return std::clamp(terrain.HeightRange(floor)[0] - bottom_m, 0.0, box.size_m.z());
}

}  // namespace

UprightBox BoxAround(const Scene& scene, std::uint32_t object, double heading_rad) {
  const Frame box_from_enu = StandingFrame(0, 0, 0, heading_rad).inverse();
  const double kInf = std::numeric_limits<double>::infinity();
  Vector3d low = Vector3d::Constant(kInf), high = Vector3d::Constant(-kInf);
  for (const Mesh& mesh : scene.meshes) {
    if (mesh.object != object) continue;
    for (const Eigen::Vector3f& vertex : mesh.vertices_m) {
      const Vector3d p = box_from_enu * Vector3d(vertex.cast<double>());
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  return {box_from_enu.inverse() * Vector3d((low + high) / 2.0), high - low, heading_rad};
}

Scene BuildScene(const SiteConfig& site, const Terrain& terrain, SiteState state) {
  Scene scene;
  scene.origin = site.origin.Geodetic();
  scene.sun = {site.sun.azimuth_deg * core::kRadFromDeg, site.sun.elevation_deg * core::kRadFromDeg,
               site.sun.sky_share};
  AddGround(scene, site, terrain);
  const Existence absent = state == SiteState::kBefore ? Existence::kNew : Existence::kGone;
  for (const Placed& placed : PlaceThings(site, terrain, kFirstThingId)) {
    if (placed.state == absent) continue;
    const std::size_t first_mesh = scene.meshes.size();
    std::visit(ThingBuilder(scene, terrain, placed), placed.what);
    if (scene.meshes.size() == first_mesh) continue;
    scene.objects.push_back({placed.id, placed.name, placed.cls,
                             BoxAround(scene, placed.id, placed.heading_rad),
                             placed.state != Existence::kNew, placed.begin_s, placed.end_s});
    scene.objects.back().buried_m = BuriedDepth(scene.objects.back().box, terrain);
  }
  return scene;
}

Scene BuildScene(const SiteConfig& site, SiteState state) {
  return BuildScene(site, Terrain(site), state);
}

}  // namespace kawara::sim
