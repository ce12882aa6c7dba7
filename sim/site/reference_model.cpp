#include "sim/site/reference_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/site/placement.hpp"
#include "sim/site/text_file.hpp"

namespace kawara::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector3d At(const Vector2d& p, double up_m) { return {p.x(), p.y(), up_m}; }

/// Floor, walls up to `top_m` and a level top: what flat roofs come to, and every lod 1 block.
std::vector<ReferenceBuilding::Surface> Block(const std::vector<Vector2d>& footprint, double foot_m,
                                              double top_m) {
  std::vector<ReferenceBuilding::Surface> surfaces(2);
  surfaces[0].role = SurfaceRole::kGround;
  surfaces[1].role = SurfaceRole::kRoof;
  for (std::size_t i = 0; i < footprint.size(); ++i) {
    const Vector2d &p = footprint[i], &q = footprint[(i + 1) % footprint.size()];
    surfaces[0].ring_enu_m.insert(surfaces[0].ring_enu_m.begin(), At(p, foot_m));
    surfaces[1].ring_enu_m.push_back(At(p, top_m));
    surfaces.push_back(
        {SurfaceRole::kWall, {At(p, foot_m), At(q, foot_m), At(q, top_m), At(p, top_m)}});
  }
  return surfaces;
}

/// Gable or hip over a rectangle; the ridge runs along the longer side.
std::vector<ReferenceBuilding::Surface> Pitched(std::vector<Vector2d> c, RoofType type,
                                                double foot_m, double eaves_m, double ridge_m) {
  if ((c[1] - c[0]).norm() < (c[2] - c[1]).norm()) std::rotate(c.begin(), c.begin() + 1, c.end());
  const Vector2d way = (c[1] - c[0]).normalized();
  const double half = (c[1] - c[0]).norm() / 2.0;
  constexpr double kLeast_m = 0.15;  // half a ridge, so that no side is a line
  const double inset =
      type == RoofType::kHip ? half - std::max(kLeast_m, half - (c[2] - c[1]).norm() / 2.0) : 0.0;
  const Vector3d r0 = At((c[3] + c[0]) / 2.0 + way * inset, ridge_m);
  const Vector3d r1 = At((c[1] + c[2]) / 2.0 - way * inset, ridge_m);
  std::vector<ReferenceBuilding::Surface> s = Block(c, foot_m, eaves_m);
  s.erase(s.begin() + 1);
  const auto eave = [&](std::size_t i) { return At(c[i], eaves_m); };
  s.push_back({SurfaceRole::kRoof, {eave(0), eave(1), r1, r0}});
  s.push_back({SurfaceRole::kRoof, {eave(2), eave(3), r0, r1}});
  if (type == RoofType::kHip) {
    s.push_back({SurfaceRole::kRoof, {eave(1), eave(2), r1}});
    s.push_back({SurfaceRole::kRoof, {eave(3), eave(0), r0}});
  } else {  // walls 1 and 3 grow a peak; s[0] is the floor
    s[2].ring_enu_m.insert(s[2].ring_enu_m.begin() + 3, r1);
    s[4].ring_enu_m.insert(s[4].ring_enu_m.begin() + 3, r0);
  }
  return s;
}

const char* RoleName(SurfaceRole role) {
  switch (role) {
    case SurfaceRole::kGround:
      return "GroundSurface";
    case SurfaceRole::kWall:
      return "WallSurface";
    case SurfaceRole::kRoof:
      break;
  }
  return "RoofSurface";
}

/// Vertices of a CityJSON file: whole numbers of a nano-degree and a millimetre from an origin.
class CityJsonVertices {
 public:
  explicit CityJsonVertices(const core::Geodetic& origin)
      : enu_(origin),
        lat_deg_(origin.lat_rad * core::kDegFromRad),
        lon_deg_(origin.lon_rad * core::kDegFromRad),
        h_m_(origin.h_ellipsoidal_m) {}
  std::size_t Add(const Vector3d& p_enu_m) {
    const core::Geodetic g = enu_.ToGeodetic(p_enu_m);
    const std::array whole{std::llround((g.lat_rad * core::kDegFromRad - lat_deg_) / kScaleDeg),
                           std::llround((g.lon_rad * core::kDegFromRad - lon_deg_) / kScaleDeg),
                           std::llround((g.h_ellipsoidal_m - h_m_) / kScaleM)};
    text_ += (count_ > 0 ? ",\n" : "\n") + std::string("[") + std::to_string(whole[0]) + ", " +
             std::to_string(whole[1]) + ", " + std::to_string(whole[2]) + "]";
    return count_++;
  }
  std::string Text() const { return "\"vertices\": [" + text_ + "]"; }
  std::string Transform() const {
    return "\"transform\": {\"scale\": [1e-9, 1e-9, 0.001], \"translate\": [" +
           Fixed(lat_deg_, 10) + ", " + Fixed(lon_deg_, 10) + ", " + Fixed(h_m_, 4) + "]}";
  }

 private:
  static constexpr double kScaleDeg = 1e-9;
  static constexpr double kScaleM = 0.001;
  core::LocalEnu enu_;
  double lat_deg_, lon_deg_, h_m_;
  std::string text_;
  std::size_t count_ = 0;
};

/// A solid of one shell. Corners are written once each, so that neighbours share them.
std::string Solid(CityJsonVertices& vertices, const char* lod,
                  const std::vector<ReferenceBuilding::Surface>& surfaces, bool semantics) {
  std::vector<std::pair<Vector3d, std::size_t>> known;
  std::string rings, values;
  for (const auto& surface : surfaces) {
    std::string ring;
    for (const Vector3d& p : surface.ring_enu_m) {
      auto at = std::find_if(known.begin(), known.end(),
                             [&p](const auto& k) { return (k.first - p).norm() < 1e-6; });
      if (at == known.end()) at = known.insert(known.end(), {p, vertices.Add(p)});
      ring += (ring.empty() ? "" : ", ") + std::to_string(at->second);
    }
    rings += (rings.empty() ? "[[" : ", [[") + ring + "]]";
    values += (values.empty() ? "" : ", ") + std::to_string(static_cast<int>(surface.role));
  }
  std::string text = "{\"type\": \"Solid\", \"lod\": \"" + std::string(lod) +
                     "\", \"boundaries\": [[" + rings + "]]";
  if (semantics) {
    text += ", \"semantics\": {\"surfaces\": [";
    for (const SurfaceRole role : {SurfaceRole::kGround, SurfaceRole::kWall, SurfaceRole::kRoof})
      text += std::string(role == SurfaceRole::kGround ? "" : ", ") + "{\"type\": \"" +
              RoleName(role) + "\"}";
    text += "], \"values\": [[" + values + "]]}";
  }
  return text + "}";
}

std::string GeoJsonPolygon(const core::LocalEnu& enu, const char* name,
                           const std::vector<Vector3d>& ring_enu_m) {
  std::string ring;
  for (std::size_t i = 0; i <= ring_enu_m.size(); ++i)
    ring += (i > 0 ? ", " : "") + JsonPosition(enu.ToGeodetic(ring_enu_m[i % ring_enu_m.size()]));
  return std::string("{\"type\": \"Feature\", \"properties\": {\"name\": \"") + name +
         "\"}, \"geometry\": {\"type\": \"Polygon\", \"coordinates\": [[" + ring + "]]}}";
}

}  // namespace

std::vector<ReferenceBuilding> ReferenceBuildings(const SiteConfig& site, const Terrain& terrain) {
  std::vector<ReferenceBuilding> buildings;
  for (const Placed& placed : PlaceThings(site, terrain, 1)) {
    const auto* config = std::get_if<BuildingConfig>(&placed.what);
    if (config == nullptr || placed.state == Existence::kNew) continue;
    ReferenceBuilding b;
    b.name = placed.name;
    b.footprint_enu_m = ToVectors(config->Corners());
    const auto [low, high] = terrain.HeightRange(b.footprint_enu_m);
    b.ground_m = low;
    b.eaves_m = high + config->height_m;
    b.top_m = b.eaves_m + config->roof.rise_m;
    b.roof = config->roof.type;
    b.storeys = config->storeys;
    b.surfaces = b.roof == RoofType::kFlat
                     ? Block(b.footprint_enu_m, b.ground_m, b.top_m)
                     : Pitched(b.footprint_enu_m, b.roof, b.ground_m, b.eaves_m, b.top_m);
    buildings.push_back(std::move(b));
  }
  return buildings;
}

std::vector<Vector3d> RoadPolygon(const SiteConfig& site, const Terrain& terrain,
                                  bool with_pavement) {
  const double half_m =
      with_pavement ? site.road.OuterHalfWidth() - kRoadVerge_m : site.road.width_m / 2.0;
  const double length_m = RoadLength(site.road);
  std::vector<Vector3d> right, ring;
  const auto stand = [&terrain](const Vector2d& p) {
    return At(p, terrain.GroundHeight(p.x(), p.y()));
  };
  for (const RoadStation& station : terrain.road()) {
    if (station.along_m < -1e-6 || station.along_m > length_m + 1e-6) continue;
    right.push_back(stand(station.middle_m - station.left * half_m));
    ring.push_back(stand(station.middle_m + station.left * half_m));
  }
  std::reverse(ring.begin(), ring.end());
  right.insert(right.end(), ring.begin(), ring.end());
  return right;
}

core::Expected<void> WriteReferenceCityJson(const SiteConfig& site, const Terrain& terrain,
                                            const std::string& path) {
  CityJsonVertices vertices(site.origin.Geodetic());
  std::string objects;
  for (const ReferenceBuilding& b : ReferenceBuildings(site, terrain)) {
    const char* roof = b.roof == RoofType::kFlat    ? "flat"
                       : b.roof == RoofType::kGable ? "gable"
                                                    : "hip";
    objects += (objects.empty() ? "\n" : ",\n") + JsonText(b.name) +
               ": {\"type\": \"Building\", \"attributes\": {\"measuredHeight\": " +
               Fixed(b.top_m - b.ground_m, 3) + ", \"roofType\": \"" + roof +
               "\", \"storeysAboveGround\": " + std::to_string(b.storeys) + "}, \"geometry\": [" +
               Solid(vertices, "1.2", Block(b.footprint_enu_m, b.ground_m, b.top_m), false) + ", " +
               Solid(vertices, "2.2", b.surfaces, true) + "]}";
  }
  return WriteTextFile(
      path, "{\"type\": \"CityJSON\", \"version\": \"1.1\",\n\"metadata\": {\"title\": " +
                JsonText(site.name) +
                ", \"referenceSystem\": \"https://www.opengis.net/def/crs/EPSG/0/4979\"},\n" +
                vertices.Transform() + ",\n\"CityObjects\": {" + objects + "},\n" +
                vertices.Text() + "}\n");
}

core::Expected<void> WriteRoadGeoJson(const SiteConfig& site, const Terrain& terrain,
                                      const std::string& path) {
  const core::LocalEnu enu(site.origin.Geodetic());
  return WriteTextFile(
      path, "{\"type\": \"FeatureCollection\", \"features\": [\n" +
                GeoJsonPolygon(enu, "carriageway", RoadPolygon(site, terrain, false)) + ",\n" +
                GeoJsonPolygon(enu, "road", RoadPolygon(site, terrain, true)) + "\n]}\n");
}

core::Expected<void> WriteGroundGrid(const SiteConfig& site, const Terrain& terrain,
                                     const std::string& path) {
  constexpr double kCellDeg = 5e-6;  // half a metre
  constexpr double kBesideRoad = 12.0;
  const core::LocalEnu enu(site.origin.Geodetic());
  double south = 90.0, north = -90.0, west = 360.0, east = -360.0;
  for (const Vector3d& p : RoadPolygon(site, terrain, true)) {
    for (const double side : {-kBesideRoad, kBesideRoad}) {
      const core::Geodetic g = enu.ToGeodetic(p + Vector3d(side, side, 0.0));
      south = std::min(south, g.lat_rad * core::kDegFromRad);
      north = std::max(north, g.lat_rad * core::kDegFromRad);
      west = std::min(west, g.lon_rad * core::kDegFromRad);
      east = std::max(east, g.lon_rad * core::kDegFromRad);
    }
  }
  const int columns = static_cast<int>(std::ceil((east - west) / kCellDeg));
  const int rows = static_cast<int>(std::ceil((north - south) / kCellDeg));
  std::string text = "ncols " + std::to_string(columns) + "\nnrows " + std::to_string(rows) +
                     "\nxllcorner " + Fixed(west, 10) + "\nyllcorner " + Fixed(south, 10) +
                     "\ncellsize " + Fixed(kCellDeg, 10) + "\nNODATA_value -9999\n";
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      core::Geodetic g;
      g.lat_rad = (south + (rows - row - 0.5) * kCellDeg) * core::kRadFromDeg;
      g.lon_rad = (west + (column + 0.5) * kCellDeg) * core::kRadFromDeg;
      g.h_ellipsoidal_m = site.origin.h_ellipsoidal_m;
      const Vector3d p = enu.FromGeodetic(g);
      const double up_m = terrain.GroundHeight(p.x(), p.y());
      text += Fixed(enu.ToGeodetic({p.x(), p.y(), up_m}).h_ellipsoidal_m, 3);
      text += column + 1 == columns ? '\n' : ' ';
    }
  }
  std::string projection = path;
  projection.replace(projection.rfind('.'), std::string::npos, ".prj");
  if (auto done = WriteTextFile(projection,
                                "GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\","
                                "6378137,298.257223563]],PRIMEM[\"Greenwich\",0],"
                                "UNIT[\"degree\",0.0174532925199433]]\n");
      !done)
    return done;
  return WriteTextFile(path, text);
}

}  // namespace kawara::sim
