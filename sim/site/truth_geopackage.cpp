#include "sim/site/truth_geopackage.hpp"

#include <array>
#include <cmath>

#include "gis/polygon_file.hpp"
#include "sim/site/reference_model.hpp"
#include "sim/site/truth_objects.hpp"

namespace kawara::sim {
namespace {

using gis::FieldType;

Eigen::Vector3d LonLatH(const core::LocalEnu& enu, const Eigen::Vector3d& p_enu_m) {
  const core::Geodetic g = enu.ToGeodetic(p_enu_m);
  return {g.lon_rad * core::kDegFromRad, g.lat_rad * core::kDegFromRad, g.h_ellipsoidal_m};
}

std::vector<Eigen::Vector3d> Ring(const core::LocalEnu& enu,
                                  const std::vector<Eigen::Vector3d>& ring_enu_m) {
  std::vector<Eigen::Vector3d> ring;
  for (const Eigen::Vector3d& p : ring_enu_m) ring.push_back(LonLatH(enu, p));
  return ring;
}

gis::FieldValue OrNull(const std::optional<double>& value) {
  return value ? gis::FieldValue(*value) : gis::FieldValue();
}

gis::PolygonLayer ObjectsLayer(const Scene& scene, const core::LocalEnu& enu) {
  gis::PolygonLayer layer{"objects",
                          "True objects of the simulated site",
                          {{"object", FieldType::kInteger, true},
                           {"name", FieldType::kText, true},
                           {"class", FieldType::kText, true},
                           {"in_reference", FieldType::kFlag, true},
                           {"begin_s", FieldType::kReal, false},
                           {"end_s", FieldType::kReal, false},
                           {"length_m", FieldType::kReal, true},
                           {"width_m", FieldType::kReal, true},
                           {"height_m", FieldType::kReal, true},
                           {"heading_deg", FieldType::kReal, true}},
                          {}};
  constexpr std::array<std::array<std::size_t, 4>, 6> kFaces{
      {{3, 2, 1, 0}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};
  for (const SceneObject& object : StandingObjects(scene)) {
    const UprightBox box = VisibleBox(object);
    const auto apexes = Apexes(box);
    gis::PolygonFeature feature;
    for (const auto& face : kFaces) {
      auto& ring = feature.faces_lon_lat_h.emplace_back();
      for (const std::size_t i : face) ring.push_back(LonLatH(enu, apexes[i]));
    }
    const double heading_deg =
        std::fmod(core::WrapPi(box.heading_rad) * core::kDegFromRad + 360.0, 360.0);
    feature.values = {static_cast<std::int64_t>(object.id),
                      object.name,
                      std::string(NameOf(object.cls)),
                      object.in_reference,
                      OrNull(object.begin_s),
                      OrNull(object.end_s),
                      box.size_m.x(),
                      box.size_m.y(),
                      box.size_m.z(),
                      heading_deg};
    layer.features.push_back(std::move(feature));
  }
  return layer;
}

gis::PolygonLayer BuildingsLayer(const SiteConfig& site, const Terrain& terrain,
                                 const core::LocalEnu& enu) {
  gis::PolygonLayer layer{"reference_buildings",
                          "Buildings before the disaster",
                          {{"name", FieldType::kText, true},
                           {"height_m", FieldType::kReal, true},
                           {"eaves_m", FieldType::kReal, true},
                           {"storeys", FieldType::kInteger, true}},
                          {}};
  for (const ReferenceBuilding& b : ReferenceBuildings(site, terrain)) {
    std::vector<Eigen::Vector3d> foot;
    for (const Eigen::Vector2d& p : b.footprint_enu_m) foot.emplace_back(p.x(), p.y(), b.ground_m);
    gis::PolygonFeature feature;
    feature.faces_lon_lat_h.push_back(Ring(enu, foot));
    feature.values = {b.name, b.top_m - b.ground_m, b.eaves_m - b.ground_m,
                      static_cast<std::int64_t>(b.storeys)};
    layer.features.push_back(std::move(feature));
  }
  return layer;
}

gis::PolygonLayer RoadsLayer(const SiteConfig& site, const Terrain& terrain,
                             const core::LocalEnu& enu) {
  gis::PolygonLayer layer{
      "reference_roads", "Road before the disaster", {{"name", FieldType::kText, true}}, {}};
  for (const bool with_pavement : {false, true}) {
    gis::PolygonFeature feature;
    feature.faces_lon_lat_h.push_back(Ring(enu, RoadPolygon(site, terrain, with_pavement)));
    feature.values = {std::string(with_pavement ? "road" : "carriageway")};
    layer.features.push_back(std::move(feature));
  }
  return layer;
}

}  // namespace

core::Expected<void> WriteTruthGeoPackage(const Scene& scene, const SiteConfig& site,
                                          const Terrain& terrain, const std::string& path) {
  const core::LocalEnu enu(scene.origin);
  const std::array layers{ObjectsLayer(scene, enu), BuildingsLayer(site, terrain, enu),
                          RoadsLayer(site, terrain, enu)};
  return gis::WritePolygonFile(path, layers);
}

}  // namespace kawara::sim
