#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/expected.hpp"

namespace kawara::vision {

/// Rings in the map's plane [m], not closed, in either sense.
struct RoadPolygon {
  std::string name;
  std::vector<Eigen::Vector2d> outer;
  std::vector<std::vector<Eigen::Vector2d>> holes;
};

/// The road as the GIS knows it: where the robot looks for changes. Several polygons may touch and
/// overlap. Immutable; any thread.
class RoadArea {
 public:
  /// Distances are known up to here from an edge.
  static constexpr double kNear = 4.0;

  /// Errors: kInvalidArgument (no polygon, a ring of fewer than three corners, a number that is not
  /// finite).
  static core::Expected<RoadArea> Make(std::vector<RoadPolygon> polygons);

  bool Contains(const Eigen::Vector2d& p) const;
  /// To the nearest edge of the union, positive inside; cut at +-kNear.
  double SignedDistance(const Eigen::Vector2d& p) const;

  const std::vector<RoadPolygon>& polygons() const { return polygons_; }
  const Eigen::Vector2d& min_m() const { return min_m_; }
  const Eigen::Vector2d& max_m() const { return max_m_; }

 private:
  struct Edge {
    Eigen::Vector2d a, b;
    std::size_t polygon;
  };
  void AddRing(const std::vector<Eigen::Vector2d>& ring, std::size_t polygon);
  /// Of all polygons but `but`.
  bool InsideAny(const Eigen::Vector2d& p, std::size_t but) const;

  std::vector<RoadPolygon> polygons_;
  std::vector<Edge> edges_;
  std::unordered_map<std::int64_t, std::vector<std::uint32_t>> strips_;  ///< by y: what crosses
  std::unordered_map<std::int64_t, std::vector<std::uint32_t>> cells_;   ///< what is within kNear
  Eigen::Vector2d min_m_ = Eigen::Vector2d::Zero(), max_m_ = Eigen::Vector2d::Zero();
};

}  // namespace kawara::vision
