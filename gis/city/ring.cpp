#include "gis/city/ring.hpp"

#include <algorithm>

namespace kawara::gis {

double PlanArea(const std::vector<Eigen::Vector3d>& ring_m) {
  double twice = 0.0;
  for (std::size_t i = 0; i < ring_m.size(); ++i) {
    // From the first corner, so that far coordinates lose no digits.
    const Eigen::Vector3d a = ring_m[i] - ring_m[0],
                          b = ring_m[(i + 1) % ring_m.size()] - ring_m[0];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice / 2.0;
}

bool CleanRing(std::vector<Eigen::Vector3d>& ring_m) {
  constexpr double kSame_m = 1e-4;
  for (const Eigen::Vector3d& p : ring_m)
    if (!p.allFinite()) return false;
  const auto same = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return (a - b).norm() < kSame_m;
  };
  ring_m.erase(std::unique(ring_m.begin(), ring_m.end(), same), ring_m.end());
  while (ring_m.size() > 1 && same(ring_m.front(), ring_m.back())) ring_m.pop_back();
  return ring_m.size() >= 3;
}

}  // namespace kawara::gis
