#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

/// Plane polygons: corners in order, closed from the last to the first. Pure functions, any thread.
namespace kawara::sim {

/// Twice the area would be positive for counter-clockwise corners; this is the area itself, signed.
double SignedArea(const std::vector<Eigen::Vector2d>& corners);
bool Contains(const std::vector<Eigen::Vector2d>& corners, const Eigen::Vector2d& point);
/// From a point to the nearest side; 0 inside.
double DistanceTo(const std::vector<Eigen::Vector2d>& corners, const Eigen::Vector2d& point);
double DistanceToSegment(const Eigen::Vector2d& point, const Eigen::Vector2d& a,
                         const Eigen::Vector2d& b);
/// At least 3 corners, counter-clockwise, no side touches another but its neighbours'.
bool IsSimplePolygon(const std::vector<Eigen::Vector2d>& corners);
bool IsSimplePolygon(const std::vector<std::array<double, 2>>& corners);

/// Corner numbers of triangles that fill a simple counter-clockwise polygon (ear clipping).
std::vector<std::array<std::uint32_t, 3>> Triangulate(const std::vector<Eigen::Vector2d>& corners);

/// The part of a convex polygon left of the line from a to b (towards it: counter-clockwise
/// inside).
std::vector<Eigen::Vector2d> CutLeft(const std::vector<Eigen::Vector2d>& convex,
                                     const Eigen::Vector2d& a, const Eigen::Vector2d& b);

std::vector<Eigen::Vector2d> ToVectors(const std::vector<std::array<double, 2>>& corners);

}  // namespace kawara::sim
