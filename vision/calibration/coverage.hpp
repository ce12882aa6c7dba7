#pragma once
#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "vision/calibration/board.hpp"
#include "vision/image.hpp"

namespace kawara::vision {

/// The rim of a round picture on black, as fisheyes and mirrors make it: found in the brightest
/// that every pixel was in any of the pictures. One thread.
class BrightestPicture {
 public:
  /// All pictures of the size of the first.
  void Add(const ConstImageView& picture);
  /// Radius about `center_px` [px]. Empty: the picture is not round, or reaches over its frame.
  std::optional<double> RimPx(const Eigen::Vector2d& center_px) const;

 private:
  std::vector<std::uint8_t> level_;
  int width_px_ = 0, height_px_ = 0;
};

/// Where in the picture corners were: cells of a disc about the centre, rings by sectors.
struct Coverage {
  static constexpr int kRings = 6, kSectors = 12;
  std::array<std::array<int, kSectors>, kRings> corners{};
  double low_px = 0.0, high_px = 0.0;  ///< nearest and farthest corner
  double rim_px = 0.0;                 ///< of the disc: the picture's rim, or half its smaller side

  /// Of the disc's radius from the innermost corner's on, how much corners reach over.
  double RadiusShare() const;
  /// Of the cells from the innermost corner's ring on, how many hold a corner.
  double CellShare() const;
  /// Where half the cells and more of a sector are empty, as a clock's hours with 12 up in the
  /// picture: "2-4, 9-10 o'clock". Empty: nowhere.
  std::string EmptyHours() const;
};

Coverage CoverageOf(const std::vector<BoardView>& views, const Eigen::Vector2d& center_px,
                    double rim_px);

}  // namespace kawara::vision
