#include "vision/calibration/grid_growth.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <set>

namespace kawara::vision {
namespace {

/// From a corner to where its neighbour is expected, in parts of the step.
constexpr double kSearch = 0.35;
/// Corners nearer than this cannot be told apart [px].
constexpr double kLeastStepPx = 4.0;
/// The first step from a seed is at most this share of the picture's smaller side.
constexpr double kLargestStepShare = 0.4;
/// The first step's direction against the corner's edge: cosine.
constexpr double kAlong = 0.94;
/// Seeds that are tried.
constexpr int kSeeds = 400;
/// Bright squares of neighbours lie square to each other, before the camera bends them.
constexpr double kMostTurn = 0.75;
/// Of an edge's contrast along its length, and against the neighbouring edges'.
constexpr double kLeastContrast = 6.0, kContrastShare = 0.25;

constexpr std::array<std::pair<int, int>, 4> kSides{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

/// Saddle points by place.
class Buckets {
 public:
  Buckets(const std::vector<SaddlePoint>& points, int width_px, int height_px)
      : points_(points), across_(width_px / kSize + 1), down_(height_px / kSize + 1) {
    cells_.resize(static_cast<std::size_t>(across_) * static_cast<std::size_t>(down_));
    for (std::size_t i = 0; i < points.size(); ++i) {
      const int u = std::clamp(static_cast<int>(points[i].pixel_px.x()) / kSize, 0, across_ - 1);
      const int v = std::clamp(static_cast<int>(points[i].pixel_px.y()) / kSize, 0, down_ - 1);
      Cell(u, v).push_back(static_cast<int>(i));
    }
  }

  template <class F>
  void Near(const Eigen::Vector2d& place, double radius_px, F&& visit) const {
    const auto clamped = [](double value, int end) {
      return std::clamp(static_cast<int>(std::floor(value / kSize)), 0, end - 1);
    };
    for (int v = clamped(place.y() - radius_px, down_); v <= clamped(place.y() + radius_px, down_);
         ++v) {
      for (int u = clamped(place.x() - radius_px, across_);
           u <= clamped(place.x() + radius_px, across_); ++u) {
        for (const int i : Cell(u, v)) {
          const double distance = (points_[static_cast<std::size_t>(i)].pixel_px - place).norm();
          if (distance <= radius_px) visit(i, distance);
        }
      }
    }
  }

 private:
  static constexpr int kSize = 16;
  std::vector<int>& Cell(int u, int v) {
    return cells_[static_cast<std::size_t>(v) * static_cast<std::size_t>(across_) +
                  static_cast<std::size_t>(u)];
  }
  const std::vector<int>& Cell(int u, int v) const {
    return const_cast<Buckets*>(this)->Cell(u, v);
  }
  const std::vector<SaddlePoint>& points_;
  int across_, down_;
  std::vector<std::vector<int>> cells_;
};

class Grower {
 public:
  Grower(const GreyPicture& picture, const std::vector<SaddlePoint>& points)
      : picture_(picture), points_(points), buckets_(points, picture.width_px, picture.height_px) {}

  CornerGrid Grow(int seed) {
    grid_ = {{{0, 0}, seed}};
    used_ = {seed};
    const SaddlePoint& p = Point(seed);
    const std::array<Eigen::Vector2d, 2> along{p.edge_a, p.edge_b};
    for (const auto& side : kSides) {
      const Eigen::Vector2d direction =
          (side.first != 0 ? along[0] : along[1]) * (side.first + side.second);
      const int next = FirstNeighbour(seed, direction);
      if (next >= 0) Put(side, next);
    }
    if (grid_.size() < 3) return {};
    for (bool grown = true; grown;) {
      grown = false;
      const CornerGrid now = grid_;
      for (const auto& [place, corner] : now) {
        for (const auto& side : kSides) grown = Extend(place, corner, side) || grown;
      }
    }
    Prune();
    return grid_;
  }

 private:
  const SaddlePoint& Point(int i) const { return points_[static_cast<std::size_t>(i)]; }

  int At(int col, int row) const {
    const auto found = grid_.find({col, row});
    return found == grid_.end() ? -1 : found->second;
  }

  bool Put(std::pair<int, int> place, int corner) {
    if (grid_.contains(place) || !used_.insert(corner).second) return false;
    grid_[place] = corner;
    return true;
  }

  /// Bright on one side and dark on the other, all the way; how much, signed: left less right.
  double EdgeContrast(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
    const Eigen::Vector2d step = to - from;
    const double length = step.norm();
    const Eigen::Vector2d left =
        Eigen::Vector2d(step.y(), -step.x()) / length * std::clamp(0.15 * length, 1.5, 8.0);
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (const double part : {0.3, 0.5, 0.7}) {
      const Eigen::Vector2d place = from + part * step;
      const Eigen::Vector2d a = place + left, b = place - left;
      const double contrast =
          static_cast<double>(picture_.Sample(a.x(), a.y()) - picture_.Sample(b.x(), b.y()));
      least = std::min(least, contrast);
      most = std::max(most, contrast);
    }
    if (least > kLeastContrast) return least > kContrastShare * most ? least : 0.0;
    if (most < -kLeastContrast) return most < kContrastShare * least ? most : 0.0;
    return 0.0;
  }

  bool Joined(int a, int b) const {
    if (std::abs(Point(a).bright.dot(Point(b).bright)) > kMostTurn) return false;
    return EdgeContrast(Point(a).pixel_px, Point(b).pixel_px) != 0.0;
  }

  int FirstNeighbour(int seed, const Eigen::Vector2d& direction) const {
    const Eigen::Vector2d& from = Point(seed).pixel_px;
    // The nearest first: rings that double.
    const double farthest = kLargestStepShare * std::min(picture_.width_px, picture_.height_px);
    for (double reach = 4.0 * kLeastStepPx; reach < 2.0 * farthest; reach *= 2.0) {
      int best = -1;
      double nearest = std::min(reach, farthest);
      buckets_.Near(from, nearest, [&](int i, double distance) {
        if (i == seed || distance < kLeastStepPx || distance > nearest) return;
        if ((Point(i).pixel_px - from).dot(direction) < kAlong * distance) return;
        if (!Joined(seed, i)) return;
        best = i;
        nearest = distance;
      });
      if (best >= 0) return best;
    }
    return -1;
  }

  /// Where the corner beyond `place` is expected: as the step before it, and as the same step of
  /// the lines beside it. Empty (false): nobody knows.
  bool Expect(std::pair<int, int> place, int corner, std::pair<int, int> side,
              Eigen::Vector2d& step) const {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    int count = 0;
    const auto add = [&](int from, int to) {
      if (from < 0 || to < 0) return;
      sum += Point(to).pixel_px - Point(from).pixel_px;
      ++count;
    };
    const auto [c, r] = place;
    const auto [dc, dr] = side;
    // On both lines beside it: the mean of the two is right to the second order.
    for (const int s : {-1, 1}) {
      add(At(c + s * dr, r + s * dc), At(c + s * dr + dc, r + s * dc + dr));
    }
    const int before = At(c - dc, r - dr);
    if (count < 2 && before >= 0) {
      add(before, corner);
      const int two_before = At(c - 2 * dc, r - 2 * dr);
      if (count == 1 && two_before >= 0) {
        // The step goes on changing as it did.
        sum += 0.5 *
               (Point(corner).pixel_px - 2.0 * Point(before).pixel_px + Point(two_before).pixel_px);
      }
    }
    if (count == 0) return false;
    step = sum / count;
    return true;
  }

  bool Extend(std::pair<int, int> place, int corner, std::pair<int, int> side) {
    const std::pair<int, int> there{place.first + side.first, place.second + side.second};
    if (grid_.contains(there)) return false;
    Eigen::Vector2d step;
    if (!Expect(place, corner, side, step)) return false;
    const double length = step.norm();
    if (length < kLeastStepPx) return false;
    int best = -1;
    double nearest = kSearch * length;
    buckets_.Near(Point(corner).pixel_px + step, nearest, [&](int i, double distance) {
      if (distance > nearest || used_.contains(i) || !Joined(corner, i)) return;
      // Also to the lattice's corners beside it.
      for (const auto& [dc, dr] : kSides) {
        const int beside = At(there.first + dc, there.second + dr);
        if (beside >= 0 && beside != corner && !Joined(beside, i)) return;
      }
      best = i;
      nearest = distance;
    });
    return best >= 0 && Put(there, best);
  }

  /// Corners that hang on one neighbour only are no board's.
  void Prune() {
    for (bool pruned = true; pruned;) {
      pruned = false;
      for (auto corner = grid_.begin(); corner != grid_.end();) {
        const auto [c, r] = corner->first;
        const bool beside = At(c - 1, r) >= 0 || At(c + 1, r) >= 0;
        const bool above = At(c, r - 1) >= 0 || At(c, r + 1) >= 0;
        if (beside && above) {
          ++corner;
          continue;
        }
        corner = grid_.erase(corner);
        pruned = true;
      }
    }
  }

  const GreyPicture& picture_;
  const std::vector<SaddlePoint>& points_;
  Buckets buckets_;
  CornerGrid grid_;
  std::set<int> used_;
};

}  // namespace

std::vector<CornerGrid> GrowGrids(const GreyPicture& picture,
                                  const std::vector<SaddlePoint>& points, int wanted,
                                  int least_corners, int enough) {
  std::vector<CornerGrid> grids;
  std::set<int> taken;
  Grower grower(picture, points);
  const int seeds = std::min(kSeeds, static_cast<int>(points.size()));
  for (int seed = 0; seed < seeds; ++seed) {
    if (taken.contains(seed)) continue;
    CornerGrid grid = grower.Grow(seed);
    if (static_cast<int>(grid.size()) < least_corners) continue;
    for (const auto& [place, corner] : grid) taken.insert(corner);
    grids.push_back(std::move(grid));
    if (static_cast<int>(grids.back().size()) >= enough) break;
  }
  std::ranges::stable_sort(grids, std::ranges::greater(), &CornerGrid::size);
  if (static_cast<int>(grids.size()) > wanted) grids.resize(static_cast<std::size_t>(wanted));
  return grids;
}

}  // namespace kawara::vision
