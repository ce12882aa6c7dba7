#include "gis/city/road_map.hpp"

#include <ogrsf_frmts.h>

#include <algorithm>
#include <cmath>

#include "gis/city/city_gml.hpp"
#include "gis/city/ring.hpp"
#include "gis/city/vector_file.hpp"

namespace kawara::gis {
namespace {

using Eigen::Vector3d;
using Ring = std::vector<Vector3d>;

constexpr double kLeastArea_m2 = 1e-4;

/// Adds a polygon; false: it is degenerate.
bool AddPolygon(RoadMap& map, RoadPolygon polygon) {
  if (!CleanRing(polygon.outer_m) || std::abs(PlanArea(polygon.outer_m)) < kLeastArea_m2)
    return false;
  if (PlanArea(polygon.outer_m) < 0.0) std::reverse(polygon.outer_m.begin(), polygon.outer_m.end());
  std::erase_if(polygon.holes_m, [](Ring& hole) { return !CleanRing(hole); });
  for (Ring& hole : polygon.holes_m)
    if (PlanArea(hole) > 0.0) std::reverse(hole.begin(), hole.end());
  map.polygons.push_back(std::move(polygon));
  return true;
}

/// Takes OGR's geometries apart.
class Collector {
 public:
  Collector(RoadMap& map, const VectorFeature& feature, std::string name)
      : map_(map), feature_(feature), name_(std::move(name)) {}

  void Take(const OGRGeometry& geometry) {
    const OGRwkbGeometryType type = wkbFlatten(geometry.getGeometryType());
    bool taken = false;
    if (OGR_GT_IsSubClassOf(type, wkbPolygon)) {
      taken = TakePolygon(*geometry.toPolygon());
    } else if (OGR_GT_IsSubClassOf(type, wkbLineString)) {
      taken = TakeLine(*geometry.toLineString());
    } else if (OGR_GT_IsSubClassOf(type, wkbGeometryCollection)) {
      for (const OGRGeometry* part : *geometry.toGeometryCollection()) Take(*part);
      return;
    } else if (OGR_GT_IsSubClassOf(type, wkbPolyhedralSurface)) {
      for (const OGRPolygon* part : *geometry.toPolyhedralSurface()) Take(*part);
      return;
    }
    if (!taken) ++map_.passed_over;
  }

 private:
  Ring Points(const OGRSimpleCurve& curve) const {
    Ring ring;
    const bool flat = curve.Is3D() == FALSE;
    for (int i = 0; i < curve.getNumPoints(); ++i) {
      ring.push_back(feature_.place(curve.getX(i), curve.getY(i), flat ? 0.0 : curve.getZ(i)));
      if (flat) ring.back().z() = 0.0;
    }
    return ring;
  }
  bool TakePolygon(const OGRPolygon& polygon) {
    if (polygon.getExteriorRing() == nullptr) return false;
    RoadPolygon road{name_, Points(*polygon.getExteriorRing()), {}, polygon.Is3D() != FALSE};
    for (int i = 0; i < polygon.getNumInteriorRings(); ++i)
      road.holes_m.push_back(Points(*polygon.getInteriorRing(i)));
    return AddPolygon(map_, std::move(road));
  }
  bool TakeLine(const OGRLineString& line) {
    RoadLine road{name_, Points(line), line.Is3D() != FALSE};
    for (const Vector3d& p : road.points_m)
      if (!p.allFinite()) return false;
    if (road.points_m.size() < 2) return false;
    map_.lines.push_back(std::move(road));
    return true;
  }

  RoadMap& map_;
  const VectorFeature& feature_;
  std::string name_;
};

core::Expected<RoadMap> FromCityGml(const std::string& path, const MapFrame& frame) {
  auto objects = ReadCityGml(path, frame, CityGmlTheme::kRoads);
  if (!objects) return tl::unexpected(objects.error());
  RoadMap map;
  map.heights = objects->heights;
  map.passed_over = objects->passed_over;
  for (CityObject& road : objects->objects)
    for (CitySurface& surface : road.surfaces) {
      RoadPolygon polygon{road.name, std::move(surface.outer_m), std::move(surface.holes_m), true};
      if (!AddPolygon(map, std::move(polygon))) ++map.passed_over;
    }
  return map;
}

core::Expected<RoadMap> FromVectorFile(const std::string& path, const MapFrame& frame,
                                       const RoadOptions& options) {
  RoadMap map;
  const auto done = ForEachFeature(path, options.layer, frame, [&](const VectorFeature& feature) {
    map.heights = feature.heights;
    std::string name = TextOf(feature.row, options.name_fields);
    if (OGR_GT_IsNonLinear(feature.geometry.getGeometryType())) {
      const std::unique_ptr<OGRGeometry> straight{feature.geometry.getLinearGeometry()};
      if (straight) Collector(map, feature, std::move(name)).Take(*straight);
    } else {
      Collector(map, feature, std::move(name)).Take(feature.geometry);
    }
  });
  if (!done) return tl::unexpected(done.error());
  return map;
}

}  // namespace

core::Expected<RoadMap> ReadRoads(const std::string& path, const MapFrame& frame,
                                  const RoadOptions& options) {
  auto map = IsCityGml(path) ? FromCityGml(path, frame) : FromVectorFile(path, frame, options);
  if (map && map->polygons.empty() && map->lines.empty())
    return core::Fail(core::ErrorCode::kNotFound, path + ": it has no polygon or line of a road (" +
                                                      std::to_string(map->passed_over) +
                                                      " other things)");
  return map;
}

}  // namespace kawara::gis
