#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "vision/calibration/board_finder.hpp"
#include "vision/calibration/coverage.hpp"

namespace kawara::calibrate {

/// What a folder of pictures of a board holds.
struct BoardPictures {
  std::vector<std::string> names;  ///< of the pictures that show the board: one a view
  std::vector<vision::BoardView> views;
  int width_px = 0, height_px = 0;
  int pictures = 0;  ///< all that could be read and are of one size
  std::size_t corners = 0;
  vision::BrightestPicture brightest;
  std::vector<std::string> warnings;  ///< pictures left out, and why
};

/// Finds the board in all JPEG and PNG files of a folder, in the order of their names. The first
/// readable picture says the size. Errors, one line: kNotFound (no folder, no pictures in it),
/// kFormat (none can be read, none shows the board, or another board than `board`).
core::Expected<BoardPictures> FindBoards(const std::filesystem::path& folder,
                                         const vision::Board& board);

}  // namespace kawara::calibrate
