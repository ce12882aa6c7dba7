#pragma once
#include <map>
#include <utility>
#include <vector>

#include "vision/calibration/saddle_points.hpp"

namespace kawara::vision {

/// A chessboard's corners as a picture shows them: (column, row) of a lattice to the saddle point
/// there, an index. Where the lattice begins is arbitrary.
using CornerGrid = std::map<std::pair<int, int>, int>;

/// The largest lattices of saddle points that are joined by edges as a chessboard's corners are:
/// along an edge one side is bright and the other dark, they change sides at every corner, and the
/// steps change only little from corner to corner. Nothing is asked of the camera: the lattice may
/// be bent as a mirror bends it. At most `wanted`, of at least `least_corners`, largest first.
/// `enough`: stops at a lattice of so many corners.
std::vector<CornerGrid> GrowGrids(const GreyPicture& picture,
                                  const std::vector<SaddlePoint>& points, int wanted,
                                  int least_corners, int enough);

}  // namespace kawara::vision
