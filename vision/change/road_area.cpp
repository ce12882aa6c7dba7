#include "vision/change/road_area.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kawara::vision {
namespace {

constexpr double kCell = 4.0;
constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

std::int64_t CellOf(double v) { return static_cast<std::int64_t>(std::floor(v / kCell)); }

std::int64_t KeyOf(std::int64_t x, std::int64_t y) { return x * (std::int64_t{1} << 32) + y; }

double DistanceToSegment(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                         const Eigen::Vector2d& b) {
  const Eigen::Vector2d ab = b - a;
  const double length2 = ab.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * ab).norm();
}

tl::unexpected<core::Error> Invalid(const std::string& what) {
  return core::Fail(core::ErrorCode::kInvalidArgument, "road: " + what);
}

core::Expected<void> CheckRing(const std::vector<Eigen::Vector2d>& ring, const std::string& name) {
  if (ring.size() < 3) return Invalid("'" + name + "' has a ring of fewer than three corners");
  for (const Eigen::Vector2d& p : ring) {
    if (!(p.cwiseAbs().maxCoeff() < 1e7))
      return Invalid("'" + name + "' has a corner farther than 10,000 km from the map's origin");
  }
  return {};
}

}  // namespace

core::Expected<RoadArea> RoadArea::Make(std::vector<RoadPolygon> polygons) {
  if (polygons.empty()) return Invalid("no polygon");
  for (const RoadPolygon& polygon : polygons) {
    if (auto ok = CheckRing(polygon.outer, polygon.name); !ok) return tl::unexpected(ok.error());
    for (const auto& hole : polygon.holes)
      if (auto ok = CheckRing(hole, polygon.name); !ok) return tl::unexpected(ok.error());
  }
  RoadArea area;
  area.polygons_ = std::move(polygons);
  area.min_m_ = area.max_m_ = area.polygons_.front().outer.front();
  for (std::size_t i = 0; i < area.polygons_.size(); ++i) {
    area.AddRing(area.polygons_[i].outer, i);
    for (const auto& hole : area.polygons_[i].holes) area.AddRing(hole, i);
  }
  return area;
}

void RoadArea::AddRing(const std::vector<Eigen::Vector2d>& ring, std::size_t polygon) {
  for (std::size_t i = 0; i < ring.size(); ++i) {
    // Long edges in pieces, so that each piece is near few cells.
    const Eigen::Vector2d from = ring[i], to = ring[(i + 1) % ring.size()];
    const auto pieces =
        std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil((to - from).norm() / 16.0)));
    for (std::size_t k = 0; k < pieces; ++k) {
      const auto at = [&](std::size_t n) -> Eigen::Vector2d {
        if (n == pieces) return to;
        return from + (to - from) * (static_cast<double>(n) / static_cast<double>(pieces));
      };
      const Edge edge{at(k), at(k + 1), polygon};
      const auto index = static_cast<std::uint32_t>(edges_.size());
      edges_.push_back(edge);
      const Eigen::Vector2d low = edge.a.cwiseMin(edge.b), high = edge.a.cwiseMax(edge.b);
      min_m_ = min_m_.cwiseMin(low);
      max_m_ = max_m_.cwiseMax(high);
      for (std::int64_t y = CellOf(low.y()); y <= CellOf(high.y()); ++y)
        strips_[y].push_back(index);
      for (std::int64_t y = CellOf(low.y() - kNear); y <= CellOf(high.y() + kNear); ++y)
        for (std::int64_t x = CellOf(low.x() - kNear); x <= CellOf(high.x() + kNear); ++x)
          cells_[KeyOf(x, y)].push_back(index);
    }
  }
}

bool RoadArea::InsideAny(const Eigen::Vector2d& p, std::size_t but) const {
  const auto strip = strips_.find(CellOf(p.y()));
  if (strip == strips_.end()) return false;
  // Even-odd rule: edges crossed by the ray towards +x, polygon by polygon.
  std::vector<bool> odd(polygons_.size(), false);
  for (const std::uint32_t i : strip->second) {
    const Edge& e = edges_[i];
    if ((e.a.y() > p.y()) == (e.b.y() > p.y())) continue;
    const double x = e.a.x() + (p.y() - e.a.y()) / (e.b.y() - e.a.y()) * (e.b.x() - e.a.x());
    if (x > p.x()) odd[e.polygon] = !odd[e.polygon];
  }
  for (std::size_t i = 0; i < odd.size(); ++i)
    if (odd[i] && i != but) return true;
  return false;
}

bool RoadArea::Contains(const Eigen::Vector2d& p) const { return InsideAny(p, kNone); }

double RoadArea::SignedDistance(const Eigen::Vector2d& p) const {
  double nearest = kNear;
  if (const auto cell = cells_.find(KeyOf(CellOf(p.x()), CellOf(p.y()))); cell != cells_.end()) {
    for (const std::uint32_t i : cell->second) {
      const Edge& e = edges_[i];
      const double d = DistanceToSegment(p, e.a, e.b);
      if (d >= nearest) continue;
      // An edge within another polygon is no edge of the union.
      if (polygons_.size() > 1) {
        const Eigen::Vector2d ab = e.b - e.a;
        const double t =
            ab.squaredNorm() > 0 ? std::clamp((p - e.a).dot(ab) / ab.squaredNorm(), 0.0, 1.0) : 0.0;
        if (InsideAny(e.a + t * ab, e.polygon)) continue;
      }
      nearest = d;
    }
  }
  return Contains(p) ? nearest : -nearest;
}

}  // namespace kawara::vision
