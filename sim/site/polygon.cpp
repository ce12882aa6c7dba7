#include "sim/site/polygon.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace kawara::sim {
namespace {

using Eigen::Vector2d;

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }
/// Positive: c lies left of the line from a to b.
double Turn(const Vector2d& a, const Vector2d& b, const Vector2d& c) { return Cross(b - a, c - a); }

bool SegmentsTouch(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  constexpr double kTouch_m = 1e-9;
  return (Turn(a, b, c) > 0) != (Turn(a, b, d) > 0) && (Turn(c, d, a) > 0) != (Turn(c, d, b) > 0)
             ? true
             : std::min({DistanceToSegment(a, c, d), DistanceToSegment(b, c, d),
                         DistanceToSegment(c, a, b), DistanceToSegment(d, a, b)}) < kTouch_m;
}

bool InTriangle(const Vector2d& p, const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return Turn(a, b, p) >= 0 && Turn(b, c, p) >= 0 && Turn(c, a, p) >= 0;
}

}  // namespace

std::vector<Vector2d> ToVectors(const std::vector<std::array<double, 2>>& corners) {
  std::vector<Vector2d> out;
  out.reserve(corners.size());
  for (const auto& corner : corners) out.emplace_back(corner[0], corner[1]);
  return out;
}

double SignedArea(const std::vector<Vector2d>& corners) {
  double twice = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i)
    twice += Cross(corners[i] - corners[0], corners[(i + 1) % corners.size()] - corners[0]);
  return twice / 2.0;
}

bool Contains(const std::vector<Vector2d>& corners, const Vector2d& point) {
  bool inside = false;
  for (std::size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i++) {
    const Vector2d& a = corners[i];
    const Vector2d& b = corners[j];
    if ((a.y() > point.y()) != (b.y() > point.y()) &&
        point.x() < (b.x() - a.x()) * (point.y() - a.y()) / (b.y() - a.y()) + a.x())
      inside = !inside;
  }
  return inside;
}

double DistanceToSegment(const Vector2d& point, const Vector2d& a, const Vector2d& b) {
  const Vector2d along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0 ? std::clamp((point - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (point - a - t * along).norm();
}

double DistanceTo(const std::vector<Vector2d>& corners, const Vector2d& point) {
  if (Contains(corners, point)) return 0.0;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i)
    nearest =
        std::min(nearest, DistanceToSegment(point, corners[i], corners[(i + 1) % corners.size()]));
  return nearest;
}

bool IsSimplePolygon(const std::vector<Vector2d>& corners) {
  const std::size_t n = corners.size();
  if (n < 3 || SignedArea(corners) <= 1e-6) return false;
  for (std::size_t i = 0; i < n; ++i) {
    if ((corners[(i + 1) % n] - corners[i]).norm() < 1e-3) return false;
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;  // neighbours around the end
      if (SegmentsTouch(corners[i], corners[i + 1], corners[j], corners[(j + 1) % n])) return false;
    }
  }
  return true;
}

bool IsSimplePolygon(const std::vector<std::array<double, 2>>& corners) {
  return IsSimplePolygon(ToVectors(corners));
}

std::vector<std::array<std::uint32_t, 3>> Triangulate(const std::vector<Vector2d>& corners) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> left(corners.size());
  std::iota(left.begin(), left.end(), 0U);
  while (left.size() > 3) {
    // The ear whose smallest height is largest gives the best shaped triangles; any ear would do.
    std::size_t best = left.size();
    double best_shape = -1.0;
    for (std::size_t i = 0; i < left.size(); ++i) {
      const std::size_t before = (i + left.size() - 1) % left.size();
      const std::size_t after = (i + 1) % left.size();
      const Vector2d& a = corners[left[before]];
      const Vector2d& b = corners[left[i]];
      const Vector2d& c = corners[left[after]];
      const double area = Turn(a, b, c);
      if (area <= 0) continue;
      const bool empty = std::none_of(left.begin(), left.end(), [&](std::uint32_t k) {
        return k != left[before] && k != left[i] && k != left[after] &&
               InTriangle(corners[k], a, b, c);
      });
      const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
      if (empty && area / longest > best_shape) {
        best_shape = area / longest;
        best = i;
      }
    }
    if (best == left.size()) break;  // only what is flat is left
    triangles.push_back(
        {left[(best + left.size() - 1) % left.size()], left[best], left[(best + 1) % left.size()]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(best));
  }
  if (left.size() == 3) triangles.push_back({left[0], left[1], left[2]});
  return triangles;
}

std::vector<Vector2d> CutLeft(const std::vector<Vector2d>& convex, const Vector2d& a,
                              const Vector2d& b) {
  std::vector<Vector2d> kept;
  for (std::size_t i = 0; i < convex.size(); ++i) {
    const Vector2d& p = convex[i];
    const Vector2d& q = convex[(i + 1) % convex.size()];
    const double side_p = Turn(a, b, p);
    const double side_q = Turn(a, b, q);
    if (side_p >= 0) kept.push_back(p);
    if ((side_p > 0 && side_q < 0) || (side_p < 0 && side_q > 0))
      kept.push_back(p + (q - p) * (side_p / (side_p - side_q)));
  }
  return kept;
}

}  // namespace kawara::sim
