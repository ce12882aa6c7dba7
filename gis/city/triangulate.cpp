#include "gis/city/triangulate.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "gis/city/ring.hpp"

namespace kawara::gis {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Ring = std::vector<Vector3d>;

/// Newell's sum: along the normal, twice the area long.
Vector3d NormalOf(const Ring& ring) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < ring.size(); ++i)
    sum += (ring[i] - ring[0]).cross(ring[(i + 1) % ring.size()] - ring[0]);
  return sum;
}

double Cross(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// A corner in its plane, and which it is.
struct Corner {
  Vector2d at;
  Vector3d point;
};
using Outline = std::vector<Corner>;

bool Crosses(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  return Cross(a, b, c) * Cross(a, b, d) < 0.0 && Cross(c, d, a) * Cross(c, d, b) < 0.0;
}

/// Cuts the outline open to a hole at the shortest bridge that crosses neither.
void Join(Outline& outline, const Outline& hole) {
  double best = std::numeric_limits<double>::infinity();
  std::size_t from = 0, to = 0;
  const auto blocked = [](const Outline& ring, const Vector2d& a, const Vector2d& b) {
    for (std::size_t i = 0; i < ring.size(); ++i)
      if (Crosses(a, b, ring[i].at, ring[(i + 1) % ring.size()].at)) return true;
    return false;
  };
  for (std::size_t i = 0; i < outline.size(); ++i)
    for (std::size_t k = 0; k < hole.size(); ++k) {
      const double length = (outline[i].at - hole[k].at).squaredNorm();
      if (length >= best || blocked(outline, outline[i].at, hole[k].at) ||
          blocked(hole, outline[i].at, hole[k].at))
        continue;
      best = length;
      from = i;
      to = k;
    }
  if (!std::isfinite(best)) return;  // a hole that is not inside: the surface stays whole
  Outline joined(outline.begin(), outline.begin() + static_cast<std::ptrdiff_t>(from) + 1);
  for (std::size_t k = 0; k <= hole.size(); ++k) joined.push_back(hole[(to + k) % hole.size()]);
  joined.insert(joined.end(), outline.begin() + static_cast<std::ptrdiff_t>(from), outline.end());
  outline = std::move(joined);
}

/// Counter-clockwise corner i is an ear: it is convex and holds no other corner.
bool IsEar(const Outline& corners, const std::vector<std::size_t>& left, std::size_t i) {
  const std::size_t n = left.size();
  const Vector2d& a = corners[left[(i + n - 1) % n]].at;
  const Vector2d& b = corners[left[i]].at;
  const Vector2d& c = corners[left[(i + 1) % n]].at;
  if (Cross(a, b, c) <= 0.0) return false;
  for (const std::size_t other : left) {
    const Vector2d& p = corners[other].at;
    if (p == a || p == b || p == c) continue;
    if (Cross(a, b, p) >= 0.0 && Cross(b, c, p) >= 0.0 && Cross(c, a, p) >= 0.0) return false;
  }
  return true;
}

std::vector<Triangle> CutEars(const Outline& corners) {
  std::vector<Triangle> triangles;
  std::vector<std::size_t> left(corners.size());
  std::iota(left.begin(), left.end(), std::size_t{0});
  while (left.size() >= 3) {
    const std::size_t n = left.size();
    std::size_t ear = n;
    for (std::size_t i = 0; i < n && ear == n; ++i)
      if (IsEar(corners, left, i)) ear = i;
    // No ear: three in a line, or a ring that crosses itself. The flattest corner goes, without a
    // triangle if it is flat.
    const bool forced = ear == n;
    if (forced) {
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t i = 0; i < n; ++i) {
        const double area = std::abs(Cross(corners[left[(i + n - 1) % n]].at, corners[left[i]].at,
                                           corners[left[(i + 1) % n]].at));
        if (area < least) {
          least = area;
          ear = i;
        }
      }
      if (ear == n) break;  // not finite
    }
    if (!forced)
      triangles.push_back({corners[left[(ear + n - 1) % n]].point, corners[left[ear]].point,
                           corners[left[(ear + 1) % n]].point});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  return triangles;
}

}  // namespace

std::vector<Triangle> Triangulate(const CitySurface& surface) {
  constexpr double kLeastArea_m2 = 1e-6;
  Ring outer = surface.outer_m;
  if (!CleanRing(outer)) return {};
  const Vector3d normal = NormalOf(outer);
  if (!(normal.norm() > 2.0 * kLeastArea_m2)) return {};
  const Vector3d up = normal.normalized();
  const Vector3d x = up.unitOrthogonal(), y = up.cross(x);
  const auto flat = [&](const Ring& ring) {
    Outline outline;
    for (const Vector3d& p : ring)
      outline.push_back({{x.dot(p - outer[0]), y.dot(p - outer[0])}, p});
    return outline;
  };
  Outline outline = flat(outer);
  for (Ring hole : surface.holes_m) {
    if (!CleanRing(hole)) continue;
    if (NormalOf(hole).dot(up) > 0.0) std::reverse(hole.begin(), hole.end());
    Join(outline, flat(hole));
  }
  return CutEars(outline);
}

}  // namespace kawara::gis
