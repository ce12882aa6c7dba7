#pragma once
#include "vision/calibration/board.hpp"
#include "vision/image.hpp"

namespace kawara::vision {

/// What was found in a picture.
struct FoundBoard {
  /// Empty: no chessboard.
  BoardView view;
  /// Of the whole lattice that is seen, counted as Board counts. Larger than the board: another
  /// one, or the board was miscounted. Then `view` holds all of it.
  int cols = 0, rows = 0;

  /// All of `board`, either way round.
  bool IsWhole(const Board& board) const {
    return static_cast<int>(view.size()) == board.corners() && Fits(board);
  }
  bool Fits(const Board& board) const {
    return (cols <= board.cols && rows <= board.rows) || (cols <= board.rows && rows <= board.cols);
  }
};

/// Finds a chessboard in a picture of any central camera, to some hundredths of a pixel, without
/// knowing the camera: lattices of saddle points are grown from corner to corner (grid_growth.hpp),
/// in the picture and in it reduced to a half and a quarter, and refined in the picture itself. The
/// board may be partly hidden or beyond the picture's edge: then a part is found, at least 12
/// corners. Any thread.
FoundBoard FindBoard(const ConstImageView& picture, const Board& board);

}  // namespace kawara::vision
