#include "sim/site/site_config.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <set>

#include "core/config/config.hpp"

namespace kawara::sim {
namespace {

using Eigen::Vector2d;

}  // namespace

core::Geodetic OriginConfig::Geodetic() const {
  return {lat_deg * core::kRadFromDeg, lon_deg * core::kRadFromDeg, h_ellipsoidal_m};
}

double RoadConfig::OuterHalfWidth() const {
  return width_m / 2.0 + (kerb_height_m > 0 ? kerb_width_m : 0.0) + pavement_m + kRoadVerge_m;
}

bool RoadConfig::CornersFit() const {
  const std::vector<Vector2d> p = ToVectors(points_m);
  std::vector<double> cut(p.size(), 0.0);  // how much of its legs each corner's arc takes
  for (std::size_t i = 0; i + 1 < p.size(); ++i)
    if ((p[i + 1] - p[i]).norm() < 0.5) return false;
  for (std::size_t i = 1; i + 1 < p.size(); ++i) {
    const Vector2d in = (p[i] - p[i - 1]).normalized(), out = (p[i + 1] - p[i]).normalized();
    const double turn = std::abs(std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out)));
    if (turn < 1e-4) continue;
    if (turn > 2.8 || corner_radius_m < OuterHalfWidth() + 0.5) return false;
    cut[i] = corner_radius_m * std::tan(turn / 2.0);
  }
  for (std::size_t i = 0; i + 1 < p.size(); ++i)
    if (cut[i] + cut[i + 1] > (p[i + 1] - p[i]).norm()) return false;
  return true;
}

std::vector<EastNorth> BuildingConfig::Corners() const {
  if (!rectangle) return footprint_m;
  const double heading = rectangle->heading_deg * core::kRadFromDeg;
  const Vector2d ahead(std::sin(heading), std::cos(heading)), left(-ahead.y(), ahead.x());
  const Vector2d centre(rectangle->centre_m[0], rectangle->centre_m[1]);
  const double l = rectangle->size_m[0] / 2.0, w = rectangle->size_m[1] / 2.0;
  std::vector<EastNorth> corners;
  for (const auto& [x, y] : {std::pair{l, -w}, {l, w}, {-l, w}, {-l, -w}}) {
    const Vector2d corner = centre + ahead * x + left * y;
    corners.push_back({corner.x(), corner.y()});
  }
  return corners;
}

bool BuildingConfig::DoorsFit() const {
  const std::vector<Vector2d> corners = ToVectors(Corners());
  return std::all_of(doors.begin(), doors.end(), [&](const DoorConfig& door) {
    const auto side = static_cast<std::size_t>(door.side);
    if (side >= corners.size()) return false;
    const double length = (corners[(side + 1) % corners.size()] - corners[side]).norm();
    return door.at_m - door.width_m / 2.0 > 0.1 && door.at_m + door.width_m / 2.0 < length - 0.1 &&
           door.height_m < height_m - 0.1;
  });
}

bool SiteConfig::PathInside() const {
  return std::all_of(path.points.begin(), path.points.end(), [this](const WaypointConfig& p) {
    return p.at_m[0] > terrain.west_m && p.at_m[0] < terrain.east_m &&
           p.at_m[1] > terrain.south_m && p.at_m[1] < terrain.north_m;
  });
}

std::string SiteConfig::RepeatedName() const {
  std::set<std::string> names;
  std::string repeated;
  const auto look = [&](const auto& list) {
    for (const Standing& thing : list)
      if (!thing.name.empty() && !names.insert(thing.name).second && repeated.empty())
        repeated = thing.name;
  };
  look(buildings);
  look(fences);
  look(rubble);
  look(things);
  look(rows);
  look(scatter);
  return repeated;
}

core::Expected<SiteConfig> LoadSite(const std::string& path,
                                    const std::vector<std::string>& overrides) {
  return core::config::Load<SiteConfig>(path, overrides);
}

}  // namespace kawara::sim
