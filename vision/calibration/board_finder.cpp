#include "vision/calibration/board_finder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "vision/calibration/grid_growth.hpp"
#include "vision/calibration/saddle_points.hpp"

namespace kawara::vision {
namespace {

constexpr int kMostSaddles = 6000;
constexpr int kLeastCorners = 12;
/// Blur before corners are looked for [px]; a picture's noise asks for more than a good one's.
constexpr double kBlursPx[] = {1.2, 2.2};
constexpr int kLevels = 3;
/// Smaller pictures show no board.
constexpr int kLeastSizePx = 160;
/// A line of the lattice with fewer of its corners is a chance alignment beside the board.
constexpr double kLeastFill = 0.5;

GreyPicture GreyOf(const ConstImageView& picture) {
  GreyPicture grey;
  grey.width_px = picture.width_px;
  grey.height_px = picture.height_px;
  grey.level.resize(picture.size_bytes() / kRgbBytes);
  for (std::size_t i = 0; i < grey.level.size(); ++i) {
    const std::uint8_t* p = picture.data + i * kRgbBytes;
    // Rec. 601.
    grey.level[i] = 0.299F * static_cast<float>(p[0]) + 0.587F * static_cast<float>(p[1]) +
                    0.114F * static_cast<float>(p[2]);
  }
  return grey;
}

/// Corner on corner, each pixel the mean of four.
GreyPicture Halved(const GreyPicture& full) {
  GreyPicture half;
  half.width_px = full.width_px / 2;
  half.height_px = full.height_px / 2;
  half.level.resize(static_cast<std::size_t>(half.width_px) *
                    static_cast<std::size_t>(half.height_px));
  std::size_t i = 0;
  for (int v = 0; v < half.height_px; ++v) {
    for (int u = 0; u < half.width_px; ++u) {
      half.level[i++] = 0.25F * (full.at(2 * u, 2 * v) + full.at(2 * u + 1, 2 * v) +
                                 full.at(2 * u, 2 * v + 1) + full.at(2 * u + 1, 2 * v + 1));
    }
  }
  return half;
}

/// With (0, 0) its first corner, and lines at the sides that are mostly empty taken off.
struct Lattice {
  CornerGrid grid;
  int cols = 0, rows = 0;
};

Lattice Trimmed(const CornerGrid& grid) {
  int low[2], high[2];
  CornerGrid kept = grid;
  const auto count = [&](int axis, int line) {
    return std::ranges::count_if(kept, [&](const auto& corner) {
      return (axis == 0 ? corner.first.first : corner.first.second) == line;
    });
  };
  for (bool trimmed = true; trimmed && !kept.empty();) {
    trimmed = false;
    low[0] = low[1] = std::numeric_limits<int>::max();
    high[0] = high[1] = std::numeric_limits<int>::min();
    for (const auto& [place, corner] : kept) {
      low[0] = std::min(low[0], place.first);
      high[0] = std::max(high[0], place.first);
      low[1] = std::min(low[1], place.second);
      high[1] = std::max(high[1], place.second);
    }
    for (int axis = 0; axis < 2 && !trimmed; ++axis) {
      for (const int line : {low[axis], high[axis]}) {
        const double fill =
            static_cast<double>(count(axis, line)) / (high[1 - axis] - low[1 - axis] + 1);
        if (fill >= kLeastFill) continue;
        std::erase_if(kept, [&](const auto& corner) {
          return (axis == 0 ? corner.first.first : corner.first.second) == line;
        });
        trimmed = true;
        break;
      }
    }
  }
  Lattice lattice;
  if (kept.empty()) return lattice;
  for (const auto& [place, corner] : kept) {
    lattice.grid[{place.first - low[0], place.second - low[1]}] = corner;
  }
  lattice.cols = high[0] - low[0] + 1;
  lattice.rows = high[1] - low[1] + 1;
  return lattice;
}

/// The nearest corner beside each: how far its window may reach.
double NearestPx(const BoardView& view, const BoardCorner& corner) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const BoardCorner& other : view) {
    const double distance = (other.pixel_px - corner.pixel_px).norm();
    if (distance > 0.0) nearest = std::min(nearest, distance);
  }
  return nearest;
}

/// In the full picture. Corners that cannot be refined are left out.
BoardView Refined(const Gradient& gradient, const BoardView& rough) {
  BoardView view;
  for (const BoardCorner& corner : rough) {
    const double spacing = NearestPx(rough, corner);
    // Large enough for the edges' blur and noise, small enough for the edges to be straight.
    const double window = std::clamp(0.25 * spacing, 1.5, std::max(4.0, 0.08 * spacing));
    const auto pixel = RefineCrossing(gradient, corner.pixel_px, window);
    if (!pixel || (*pixel - corner.pixel_px).norm() > 0.3 * spacing) continue;
    view.push_back({corner.col, corner.row, *pixel});
  }
  return view;
}

}  // namespace

FoundBoard FindBoard(const ConstImageView& picture, const Board& board) {
  const GreyPicture full = GreyOf(picture);
  FoundBoard best;
  GreyPicture level = full;
  double scale = 1.0;
  for (int i = 0; i < kLevels; ++i, scale *= 2.0) {
    if (i > 0) level = Halved(level);
    if (std::min(level.width_px, level.height_px) < kLeastSizePx) break;
    for (const double blur_px : kBlursPx) {
      const auto points = FindSaddlePoints(level, blur_px, kMostSaddles);
      const auto grids = GrowGrids(level, points, 3, kLeastCorners, board.corners());
      for (const CornerGrid& grid : grids) {
        const Lattice lattice = Trimmed(grid);
        FoundBoard found;
        found.cols = lattice.cols;
        found.rows = lattice.rows;
        for (const auto& [place, corner] : lattice.grid) {
          const Eigen::Vector2d& at = points[static_cast<std::size_t>(corner)].pixel_px;
          found.view.push_back({place.first, place.second, (at.array() + 0.5) * scale - 0.5});
        }
        // A whole board goes before anything; else the larger part.
        const bool whole = found.IsWhole(board), had_whole = best.IsWhole(board);
        if (had_whole || (!whole && found.view.size() <= best.view.size())) continue;
        best = std::move(found);
      }
      if (best.IsWhole(board)) break;
    }
    if (best.IsWhole(board)) break;
  }
  const std::size_t rough = best.view.size();
  best.view = Refined(GradientOf(full), best.view);
  if (best.view.size() < kLeastCorners || best.view.size() < rough / 2) return {};
  return best;
}

}  // namespace kawara::vision
