#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <deque>
#include <unordered_map>
#include <vector>

#include "vision/change/road_axis.hpp"

namespace kawara::vision {
namespace {

constexpr double kMostCells = 1.6e7;
constexpr double kLeastBranch = 8.0;  // m

/// The road as a picture: cells of a grid, 1 where there is road.
struct Grid {
  int width = 0, height = 0;
  double cell_m = 0.5;
  Eigen::Vector2d low_m = Eigen::Vector2d::Zero();
  std::vector<std::uint8_t> on;

  std::size_t At(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
  Eigen::Vector2d CentreOf(std::size_t place) const {
    const auto w = static_cast<std::size_t>(width);
    const std::size_t column = place % w, row = place / w;
    return low_m + cell_m * Eigen::Vector2d(static_cast<double>(column) + 0.5,
                                            static_cast<double>(row) + 0.5);
  }
};

Grid Draw(const RoadArea& road) {
  Grid grid;
  const Eigen::Vector2d size = road.max_m() - road.min_m();
  while (size.x() * size.y() / (grid.cell_m * grid.cell_m) > kMostCells) grid.cell_m *= 2.0;
  // Two empty cells all round, so that neighbours need no check.
  grid.low_m = road.min_m() - Eigen::Vector2d::Constant(2.0 * grid.cell_m);
  grid.width = static_cast<int>(std::ceil(size.x() / grid.cell_m)) + 4;
  grid.height = static_cast<int>(std::ceil(size.y() / grid.cell_m)) + 4;
  grid.on.assign(grid.At(0, grid.height), 0);
  for (int y = 2; y < grid.height - 2; ++y)
    for (int x = 2; x < grid.width - 2; ++x)
      grid.on[grid.At(x, y)] = road.Contains(grid.CentreOf(grid.At(x, y))) ? 1 : 0;
  return grid;
}

/// Clockwise from above.
std::array<std::ptrdiff_t, 8> Around(const Grid& grid) {
  const std::ptrdiff_t w = grid.width;
  return {-w, -w + 1, 1, w + 1, w, w - 1, -1, -w - 1};
}

/// Zhang and Suen's two passes until nothing falls.
void Thin(Grid& grid) {
  const auto around = Around(grid);
  std::vector<std::size_t> edge;
  for (bool changed = true; changed;) {
    changed = false;
    for (const int pass : {0, 1}) {
      edge.clear();
      for (int y = 1; y < grid.height - 1; ++y)
        for (int x = 1; x < grid.width - 1; ++x) {
          const std::size_t place = grid.At(x, y);
          if (grid.on[place] == 0) continue;
          std::array<int, 8> p{};
          int sum = 0, rises = 0;
          for (std::size_t k = 0; k < 8; ++k) {
            p[k] =
                grid.on[static_cast<std::size_t>(static_cast<std::ptrdiff_t>(place) + around[k])];
            sum += p[k];
          }
          for (std::size_t k = 0; k < 8; ++k) rises += p[k] == 0 && p[(k + 1) % 8] == 1 ? 1 : 0;
          if (sum < 2 || sum > 6 || rises != 1) continue;
          const bool free = pass == 0 ? p[0] * p[2] * p[4] == 0 && p[2] * p[4] * p[6] == 0
                                      : p[0] * p[2] * p[6] == 0 && p[0] * p[4] * p[6] == 0;
          if (free) edge.push_back(place);
        }
      for (const std::size_t place : edge) grid.on[place] = 0;
      changed = changed || !edge.empty();
    }
  }
}

/// The way back from the cell of the skeleton that is farthest from `from`.
std::vector<std::size_t> FarthestFrom(const Grid& grid, std::size_t from) {
  const auto around = Around(grid);
  std::unordered_map<std::size_t, std::size_t> parent;
  std::deque<std::size_t> queue{from};
  parent[from] = from;
  std::size_t last = from;
  while (!queue.empty()) {
    last = queue.front();
    queue.pop_front();
    for (const std::ptrdiff_t step : around) {
      const auto next = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(last) + step);
      if (grid.on[next] == 0 || parent.contains(next)) continue;
      parent[next] = last;
      queue.push_back(next);
    }
  }
  std::vector<std::size_t> way{last};
  while (parent[way.back()] != way.back()) way.push_back(parent[way.back()]);
  return way;
}

/// Straight on from an end until the road ends.
void RunOn(const RoadArea& road, std::vector<Eigen::Vector2d>& line, bool at_end) {
  if (line.size() < 2) return;
  if (!at_end) std::reverse(line.begin(), line.end());
  // A skeleton bends into a corner at its end: the direction is that of some metres before.
  const std::size_t back = std::min<std::size_t>(line.size() - 1, 20);
  const std::size_t drop = std::min<std::size_t>(line.size() - 2, 6);
  line.resize(line.size() - drop);
  const Eigen::Vector2d from = line[line.size() - 1 - std::min(back, line.size() - 1)];
  const Eigen::Vector2d direction = (line.back() - from).normalized();
  constexpr double kStep = 0.25;
  constexpr int kMost = 400;
  for (int i = 0; i < kMost && direction.allFinite(); ++i) {
    const Eigen::Vector2d next = line.back() + kStep * direction;
    if (!road.Contains(next)) break;
    line.push_back(next);
  }
  if (!at_end) std::reverse(line.begin(), line.end());
}

}  // namespace

std::vector<RoadAxis> AxesOf(const RoadArea& road) {
  Grid grid = Draw(road);
  Thin(grid);
  std::vector<RoadAxis> axes;
  for (std::size_t start = 0; start < grid.on.size(); ++start) {
    if (grid.on[start] == 0) continue;
    // Twice to the farthest: the longest way through this part. What hung on it is met again.
    while (grid.on[start] != 0) {
      const auto way = FarthestFrom(grid, FarthestFrom(grid, start).front());
      for (const std::size_t place : way) grid.on[place] = 0;
      std::vector<Eigen::Vector2d> line;
      line.reserve(way.size());
      for (const std::size_t place : way) line.push_back(grid.CentreOf(place));
      if (static_cast<double>(line.size()) * grid.cell_m < kLeastBranch) continue;
      RunOn(road, line, true);
      RunOn(road, line, false);
      auto axis = AxisAlong("axis " + std::to_string(axes.size() + 1), line);
      if (axis) axes.push_back(std::move(*axis));
    }
  }
  return axes;
}

}  // namespace kawara::vision
