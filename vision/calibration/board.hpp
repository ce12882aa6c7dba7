#pragma once
#include <Eigen/Core>
#include <vector>

namespace kawara::vision {

/// A flat chessboard. Counted are its INNER corners, where four squares meet: a board of 10 x 7
/// squares is 9 x 6.
struct Board {
  int cols = 9;
  int rows = 6;
  double square_m = 0.03;  ///< a square's side

  int corners() const { return cols * rows; }
};

/// An inner corner as seen in a picture. Where only a part of the board is seen nobody knows which
/// one, and it does not matter: (col, row) then count from the part's own first corner.
struct BoardCorner {
  int col = 0;
  int row = 0;
  Eigen::Vector2d pixel_px = Eigen::Vector2d::Zero();

  /// On the board's plane [m].
  Eigen::Vector2d OnBoard(double square_m) const { return {col * square_m, row * square_m}; }
};

/// The board in one picture.
using BoardView = std::vector<BoardCorner>;

}  // namespace kawara::vision
