#include "gis/city/city_buildings.hpp"

#include <ogrsf_frmts.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "gis/city/city_gml.hpp"
#include "gis/city/city_json.hpp"
#include "gis/city/ring.hpp"
#include "gis/city/vector_file.hpp"

namespace kawara::gis {
namespace {

using Eigen::Vector3d;
using Ring = std::vector<Vector3d>;

constexpr double kLeastHeight_m = 0.3;
constexpr double kLevel_m = 0.1;

/// A level triangle at the building's foot is its floor.
bool IsFloor(const Triangle& t, double low_m) {
  for (const Vector3d& p : t)
    if (p.z() > low_m + kLevel_m) return false;
  const Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
  return std::abs(normal.z()) > 0.9;
}

/// Triangles without the floor; false: nothing stands there.
bool Finish(CityBuilding& building) {
  building.low_m = std::numeric_limits<double>::infinity();
  building.high_m = -building.low_m;
  for (const Triangle& t : building.triangles_m)
    for (const Vector3d& p : t) {
      building.low_m = std::min(building.low_m, p.z());
      building.high_m = std::max(building.high_m, p.z());
    }
  if (!(building.high_m - building.low_m >= kLeastHeight_m)) return false;
  std::erase_if(building.triangles_m,
                [&](const Triangle& t) { return IsFloor(t, building.low_m); });
  return true;
}

double SigmaOf(int lod, const BuildingOptions& options) {
  return lod == 0   ? options.sigma_footprint_m
         : lod == 1 ? options.sigma_lod1_m
                    : options.sigma_lod2_m;
}

CityModel FromObjects(CityObjects objects, const BuildingOptions& options) {
  CityModel model;
  model.heights = objects.heights;
  model.passed_over = objects.passed_over;
  for (CityObject& object : objects.objects) {
    CityBuilding building;
    building.name = std::move(object.name);
    building.lod = object.lod;
    building.date = object.date;
    building.sigma_m = object.sigma_m.value_or(SigmaOf(object.lod, options));
    for (const CitySurface& surface : object.surfaces)
      for (const Triangle& t : Triangulate(surface)) building.triangles_m.push_back(t);
    if (Finish(building)) {
      model.buildings.push_back(std::move(building));
    } else {
      ++model.passed_over;
    }
  }
  return model;
}

/// Reads footprints, and faces where the file has them.
class Footprints {
 public:
  Footprints(CityModel& model, const BuildingOptions& options) : model_(model), options_(options) {}

  void Take(const VectorFeature& feature) {
    model_.heights = feature.heights;
    std::vector<CitySurface> surfaces;
    Collect(feature, feature.geometry, surfaces);
    CityBuilding building;
    building.name = TextOf(feature.row, options_.name_fields);
    building.date = DateOf(TextOf(feature.row, options_.date_fields));
    const auto height_m = HeightOf(feature.row);
    for (const CitySurface& surface : surfaces) {
      if (feature.geometry.Is3D() != FALSE && (!IsLevel(surface) || !height_m)) {
        building.lod = 2;
        for (const Triangle& t : Triangulate(surface)) building.triangles_m.push_back(t);
      } else if (height_m) {
        Raise(surface, feature.geometry.Is3D() != FALSE, *height_m, building);
      }
    }
    const auto stated = Number(TextOf(feature.row, {"sigma_m"}));
    building.sigma_m = stated && *stated > 0.0 ? *stated : SigmaOf(building.lod, options_);
    if (Finish(building)) {
      model_.buildings.push_back(std::move(building));
    } else {
      ++model_.passed_over;
    }
  }

 private:
  /// "12.5", "12.5 m"; nullopt: no number in front.
  static std::optional<double> Number(const std::string& text) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
    return value;
  }
  std::optional<double> HeightOf(const OGRFeature& row) const {
    for (const HeightField& field : options_.height_fields) {
      const auto value = Number(TextOf(row, {field.name}));
      if (value && *value > 0.0) return *value * field.metres;
    }
    return std::nullopt;
  }
  static bool IsLevel(const CitySurface& surface) {
    const auto [low, high] =
        std::minmax_element(surface.outer_m.begin(), surface.outer_m.end(),
                            [](const Vector3d& a, const Vector3d& b) { return a.z() < b.z(); });
    return low == surface.outer_m.end() || high->z() - low->z() < kLevel_m;
  }

  static void Collect(const VectorFeature& feature, const OGRGeometry& geometry,
                      std::vector<CitySurface>& surfaces) {
    const OGRwkbGeometryType type = wkbFlatten(geometry.getGeometryType());
    if (OGR_GT_IsSubClassOf(type, wkbPolygon)) {
      const OGRPolygon& polygon = *geometry.toPolygon();
      if (polygon.getExteriorRing() == nullptr) return;
      CitySurface surface;
      surface.outer_m = Points(feature, *polygon.getExteriorRing());
      for (int i = 0; i < polygon.getNumInteriorRings(); ++i)
        surface.holes_m.push_back(Points(feature, *polygon.getInteriorRing(i)));
      surfaces.push_back(std::move(surface));
    } else if (OGR_GT_IsSubClassOf(type, wkbGeometryCollection)) {
      for (const OGRGeometry* part : *geometry.toGeometryCollection())
        Collect(feature, *part, surfaces);
    } else if (OGR_GT_IsSubClassOf(type, wkbPolyhedralSurface)) {
      for (const OGRPolygon* part : *geometry.toPolyhedralSurface())
        Collect(feature, *part, surfaces);
    }
  }
  static Ring Points(const VectorFeature& feature, const OGRLinearRing& ring) {
    Ring points;
    for (int i = 0; i < ring.getNumPoints(); ++i)
      points.push_back(feature.place(ring.getX(i), ring.getY(i), ring.getZ(i)));
    return points;
  }

  /// Walls and a level roof over a footprint.
  void Raise(CitySurface footprint, bool has_heights, double height_m, CityBuilding& building) {
    if (!CleanRing(footprint.outer_m)) return;
    std::erase_if(footprint.holes_m, [](Ring& hole) { return !CleanRing(hole); });
    double foot_m = std::numeric_limits<double>::infinity();
    for (const Vector3d& p : footprint.outer_m) {
      double up_m = has_heights ? p.z() : 0.0;
      if (!has_heights && options_.ground) up_m = options_.ground(p.x(), p.y()).value_or(0.0);
      foot_m = std::min(foot_m, up_m);
    }
    if (PlanArea(footprint.outer_m) < 0.0)
      std::reverse(footprint.outer_m.begin(), footprint.outer_m.end());
    for (Ring& hole : footprint.holes_m)
      if (PlanArea(hole) > 0.0) std::reverse(hole.begin(), hole.end());
    const auto at = [](const Vector3d& p, double up_m) { return Vector3d(p.x(), p.y(), up_m); };
    const auto walls = [&](const Ring& ring) {
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const Vector3d &p = ring[i], &q = ring[(i + 1) % ring.size()];
        const Vector3d a = at(p, foot_m), b = at(q, foot_m), c = at(q, foot_m + height_m),
                       d = at(p, foot_m + height_m);
        building.triangles_m.push_back({a, b, c});
        building.triangles_m.push_back({a, c, d});
      }
    };
    walls(footprint.outer_m);
    for (const Ring& hole : footprint.holes_m) walls(hole);
    const auto lift = [&](Ring& ring) {
      for (Vector3d& p : ring) p.z() = foot_m + height_m;
    };
    lift(footprint.outer_m);
    for (Ring& hole : footprint.holes_m) lift(hole);
    for (const Triangle& t : Triangulate(footprint)) building.triangles_m.push_back(t);
  }

  CityModel& model_;
  const BuildingOptions& options_;
};

core::Expected<CityModel> Read(const std::string& path, const MapFrame& frame,
                               const BuildingOptions& options) {
  if (IsCityGml(path)) {
    auto objects = ReadCityGml(path, frame, CityGmlTheme::kBuildings);
    if (!objects) return tl::unexpected(objects.error());
    return FromObjects(std::move(*objects), options);
  }
  if (IsCityJson(path)) {
    auto objects = ReadCityJson(path, frame);
    if (!objects) return tl::unexpected(objects.error());
    return FromObjects(std::move(*objects), options);
  }
  CityModel model;
  Footprints footprints(model, options);
  const auto done = ForEachFeature(path, options.layer, frame,
                                   [&](const VectorFeature& f) { footprints.Take(f); });
  if (!done) return tl::unexpected(done.error());
  return model;
}

}  // namespace

core::Expected<CityModel> ReadBuildings(const std::string& path, const MapFrame& frame,
                                        const BuildingOptions& options) {
  auto model = Read(path, frame, options);
  if (model && model->buildings.empty())
    return core::Fail(core::ErrorCode::kNotFound, path + ": it has no building with a height (" +
                                                      std::to_string(model->passed_over) +
                                                      " without)");
  return model;
}

}  // namespace kawara::gis
