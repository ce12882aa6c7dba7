#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/geodesy.hpp"

namespace kawara::sim {

/// What a surface looks like from near: rules by which its colour changes over the metres of it.
enum class Pattern : std::uint8_t {
  kPlain,       ///< one colour: plain paint, on which stereo has nothing to hold
  kAsphalt,     ///< grains, patches, cracks
  kConcrete,    ///< blotches, form-work joints
  kBrick,       ///< courses; repeats itself
  kTiles,       ///< square joints; repeats itself
  kCorrugated,  ///< sheet metal; repeats itself in one direction
  kGlass,       ///< mirrors the sky
  kWood,        ///< boards and grain
  kSoil,        ///< earth, gravel
  kGrass,
  kLeaves,
  kRubble,  ///< broken concrete, plaster, splinters: rich
  kCloth,   ///< clothes of people-sized clutter
};

struct Material {
  Pattern pattern = Pattern::kPlain;
  std::array<float, 3> base_rgb{0.5F, 0.5F, 0.5F};    ///< linear reflectance, 0..1
  std::array<float, 3> second_rgb{0.5F, 0.5F, 0.5F};  ///< joints, second tone
  float scale_m = 1.0F;    ///< size of the pattern's unit: brick course, tile, board
  float contrast = 1.0F;   ///< 0: as good as plain
  float gloss = 0.0F;      ///< share that mirrors at normal incidence, 0..1
  std::uint32_t seed = 0;  ///< two walls of one material do not look the same
};

/// Triangles of one material of one object, in the site's ENU [m].
struct Mesh {
  std::vector<Eigen::Vector3f> vertices_m;
  std::vector<Eigen::Vector2f> uv_m;                    ///< along the surface, metres; one a vertex
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise seen from outside
  std::uint32_t material = 0;                           ///< index into Scene::materials
  std::uint32_t object = 0;                             ///< SceneObject::id
};

/// Classes as they are registered in the GIS, and what else stands at a site.
enum class ObjectClass : std::uint8_t {
  kGround,
  kBuilding,
  kPole,
  kFence,
  kTree,
  kKerb,
  kTruck,
  kCar,
  kRubble,
  kPerson,
  kClutter
};

/// A box standing on the ground with a heading; the eight apexes follow from it.
struct UprightBox {
  Eigen::Vector3d centre_enu_m = Eigen::Vector3d::Zero();  ///< of the volume
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  ///< length (along the heading), width, height
  double heading_rad = 0.0;                          ///< true, clockwise from north
};

/// A thing of the site: what an evaluator compares found objects with.
struct SceneObject {
  std::uint32_t id = 0;  ///< 1 and up; 0 is the sky
  std::string name;      ///< as in the site file, or made by rule: "truck-1"
  ObjectClass cls = ObjectClass::kClutter;
  UprightBox box;            ///< smallest upright box around its meshes at its heading
  bool in_reference = true;  ///< the GIS knows it (there before the disaster)
  /// Seconds from the start of the mission between which it stands there; empty: open end.
  std::optional<double> begin_s;
  std::optional<double> end_s;
  /// How much of the box, from below, lies in the ground (foundations, the feet of heaps): what a
  /// robot can see of the box begins above it.
  double buried_m = 0.0;
};

struct Sun {
  double azimuth_rad = 2.6;  ///< true, clockwise from north
  double elevation_rad = 0.8;
  double sky_share = 0.35;  ///< of the light on a level surface that comes from the sky
};

/// One state of a site (before, or after the disaster) as geometry. Built by BuildScene(); not
/// changed afterwards; any thread reads it.
struct Scene {
  core::Geodetic origin;  ///< of the ENU axes
  std::vector<Material> materials;
  std::vector<Mesh> meshes;
  std::vector<SceneObject> objects;  ///< ascending id
  Sun sun;
};

}  // namespace kawara::sim
