#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "sim/site/road_line.hpp"
#include "sim/site/site_config.hpp"

namespace kawara::sim {

/// What the ground is made of at a place.
enum class GroundPart : std::uint8_t { kLand, kRoad, kMarking, kKerbLeft, kKerbRight, kPavement };

/// The ground of a site as one surface of triangles that covers every place once, seen from above:
/// land, and the road cut into it with crown, lines, kerbs (their faces lean by 3 cm) and
/// pavements. The meshes of the scene ARE these triangles and GroundHeight() interpolates in them,
/// from the same 32-bit corners; so a wheel on GroundHeight() stands on what a ray hits, to the
/// rounding of double arithmetic. Immutable; any thread.
class Terrain {
 public:
  explicit Terrain(const SiteConfig& site);

  /// Height [m] in the site's ENU. Outside the land (some 500 m away): that of the nearest land.
  double GroundHeight(double east_m, double north_m) const;
  GroundPart PartAt(double east_m, double north_m) const;

  struct Triangle {
    std::array<Eigen::Vector3f, 3> corners_m;  ///< counter-clockwise from above
    GroundPart part;
  };
  const std::vector<Triangle>& triangles() const { return triangles_; }
  const std::vector<RoadStation>& road() const { return road_; }
  /// Smallest and greatest height along the sides and inside of a polygon, for what stands on it.
  std::array<double, 2> HeightRange(const std::vector<Eigen::Vector2d>& polygon) const;

 private:
  double LandHeight(const Eigen::Vector2d& at) const;
  void LayRoad(const SiteConfig& site);
  void LayLand(const RoadConfig& road);
  void Add(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
           GroundPart part);
  std::size_t CellOf(double east_m, double north_m) const;
  std::uint32_t TriangleAt(double east_m, double north_m) const;

  struct Wave {
    Eigen::Vector2d k_per_m;
    double phase_rad;
    double amplitude_m;
  };
  TerrainConfig config_;
  std::vector<Wave> waves_;
  std::vector<double> east_lines_m_;  ///< of the grid, ascending; close in the middle, wide outside
  std::vector<double> north_lines_m_;
  std::vector<RoadStation> road_;
  std::vector<Triangle> triangles_;
  std::vector<std::vector<std::uint32_t>> cells_;  ///< triangles that touch each cell of the grid
};

}  // namespace kawara::sim
