#include "vision/stereo/coarse_matcher.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/check.hpp"
#include "vision/stereo/semi_global_kernel.hpp"

namespace kawara::vision {
namespace {

using semi_global::kPathPad;
using semi_global::kWindow;
using semi_global::PathRow;
using semi_global::PathStride;

/// How much dearer the second best must be than the best.
constexpr double kUniqueness = 0.05;
/// Rows of differences held: the window's, and the one that comes while one leaves.
constexpr std::size_t kRows = 2 * kWindow + 2;
/// More than any path costs, and far from overflowing when a step is added.
constexpr std::uint16_t kBeyond = 0x7000;

}  // namespace

void CoarseMatcher::Prepare(std::size_t width, std::size_t height, std::size_t disparities) {
  width_ = width;
  height_ = height;
  differences_.resize(kRows * width * disparities);
  row_sum_.resize(width * disparities);
  b_row_.assign(width + 2 * disparities, ContrastPlane::kMiddle);
  b_seen_row_.assign(width + 2 * disparities, 0);
  cost_.resize(width * height * disparities);
  total_.resize(width * height * disparities);
  const auto prepare = [&](Paths& paths) {
    const std::size_t stride = PathStride(disparities);
    paths.cost.assign((width + 1) * stride, 0);
    paths.least.assign(width + 1, 0);
    for (std::size_t x = 0; x <= width; ++x) {
      std::uint16_t* cost = paths.cost.data() + x * stride;
      std::fill(cost, cost + kPathPad, kBeyond);
      std::fill(cost + kPathPad + disparities, cost + stride, kBeyond);
    }
  };
  for (auto& row : rows_) {
    for (Paths& paths : row) prepare(paths);
  }
  prepare(along_);
  for (auto* row : {&best_, &best_cost_, &second_cost_}) row->assign(width, 0);
  for (auto* row : {&b_best_, &b_cost_}) row->assign(width + disparities, 0);
  repeats_.assign(width, 0);
}

void CoarseMatcher::SumDifferences(const ContrastPlane& a, const ContrastPlane& b,
                                   std::size_t disparities) {
  const std::size_t row_size = width_ * disparities;
  const auto slot = [&](std::size_t y) { return differences_.data() + y % kRows * row_size; };
  const auto fill = [&](std::size_t y) {
    std::memcpy(b_row_.data(), b.level.data() + y * width_, width_);
    std::memcpy(b_seen_row_.data(), b.seen.data() + y * width_, width_);
    semi_global::Differences(a.level.data() + y * width_, a.seen.data() + y * width_, b_row_.data(),
                             b_seen_row_.data(), width_, disparities, slot(y));
  };
  // Rows beyond the first and the last repeat these.
  for (std::size_t y = 0; y <= kWindow; ++y) fill(y);
  for (std::size_t i = 0; i < row_size; ++i) {
    row_sum_[i] = static_cast<std::uint16_t>((kWindow + 1) * slot(0)[i]);
    for (std::size_t y = 1; y <= kWindow; ++y) {
      row_sum_[i] = static_cast<std::uint16_t>(row_sum_[i] + slot(y)[i]);
    }
  }
  for (std::size_t y = 0;; ++y) {
    semi_global::WindowCosts(row_sum_.data(), width_, disparities, cost_.data() + y * row_size);
    if (y + 1 == height_) break;
    const std::size_t next = std::min(y + 1 + kWindow, height_ - 1);
    const std::size_t leaving = y >= kWindow ? y - kWindow : 0;
    if (next == y + 1 + kWindow) fill(next);
    semi_global::SlideRows(slot(next), slot(leaving), row_size, row_sum_.data());
  }
}

void CoarseMatcher::SearchDown(const ContrastPlane& a, std::size_t disparities) {
  const auto view = [](Paths& paths) { return PathRow{paths.cost.data(), paths.least.data()}; };
  int now = 0;
  for (std::size_t y = 0; y < height_; ++y, now = 1 - now) {
    const PathRow previous[3] = {view(rows_[1 - now][0]), view(rows_[1 - now][1]),
                                 view(rows_[1 - now][2])};
    const PathRow current[3] = {view(rows_[now][0]), view(rows_[now][1]), view(rows_[now][2])};
    const std::size_t at = y * width_;
    semi_global::PathsDown(cost_.data() + at * disparities, a.seen.data() + at, width_, disparities,
                           previous, current, view(along_), total_.data() + at * disparities);
  }
}

void CoarseMatcher::SearchUp(const ContrastPlane& a, std::size_t disparities,
                             std::vector<float>& disparity_px) {
  const auto view = [](Paths& paths) { return PathRow{paths.cost.data(), paths.least.data()}; };
  const std::size_t stride = PathStride(disparities);
  for (auto& row : rows_) {
    for (Paths& paths : row) {
      for (std::size_t x = 0; x <= width_; ++x) {
        std::fill_n(paths.cost.data() + x * stride + kPathPad, disparities, std::uint16_t{0});
      }
      std::fill(paths.least.begin(), paths.least.end(), std::uint16_t{0});
    }
  }
  int now = 0;
  for (std::size_t y = height_; y-- > 0; now = 1 - now) {
    const PathRow previous[3] = {view(rows_[1 - now][0]), view(rows_[1 - now][1]),
                                 view(rows_[1 - now][2])};
    const PathRow current[3] = {view(rows_[now][0]), view(rows_[now][1]), view(rows_[now][2])};
    const std::size_t at = y * width_;
    std::uint16_t* total = total_.data() + at * disparities;
    semi_global::PathsUp(cost_.data() + at * disparities, a.seen.data() + at, width_, disparities,
                         previous, current, total);
    ChooseRow(a, y, disparities, disparity_px.data() + at);
  }
}

void CoarseMatcher::ChooseRow(const ContrastPlane& a, std::size_t y, std::size_t disparities,
                              float* disparity_px) {
  const std::size_t at = y * width_;
  const std::uint16_t* total = total_.data() + at * disparities;
  const std::uint8_t* seen = a.seen.data() + at;
  const std::uint8_t* plain = a.plain.data() + at;
  semi_global::FindMinima(
      total, seen, width_, disparities,
      {best_.data(), best_cost_.data(), second_cost_.data(), b_best_.data(), b_cost_.data()});
  semi_global::FindRepeats(cost_.data() + at * disparities, best_.data(), width_, disparities,
                           repeats_.data());
  for (std::size_t x = 0; x < width_; ++x) {
    disparity_px[x] = kUnknown;
    if (seen[x] == 0 || plain[x] != 0 || repeats_[x] != 0) continue;
    const std::size_t best = best_[x];
    if (best + 1 == disparities) continue;  // perhaps nearer still
    if ((1.0 - kUniqueness) * second_cost_[x] <= best_cost_[x]) continue;
    const int back = b_best_[x + best];
    if (std::abs(back - static_cast<int>(best)) > 1) continue;
    float fraction = 0.0F;
    if (best > 0) {
      const std::uint16_t* cost = total + x * disparities + best;
      const float before = cost[-1], here = cost[0], after = cost[1];
      const float rise = std::max(before, after) - here;
      if (rise > 0.0F) fraction = (before - after) / (2.0F * rise);
    }
    disparity_px[x] = std::max(0.0F, static_cast<float>(best) + fraction);
  }
}

void CoarseMatcher::Match(const ContrastPlane& a, const ContrastPlane& b, int disparities,
                          std::vector<float>& disparity_px) {
  CORE_CHECK(a.width_px == b.width_px && a.height_px == b.height_px);
  CORE_CHECK(disparities > 0 && disparities % static_cast<int>(semi_global::kLane) == 0);
  CORE_CHECK(a.height_px > kWindow && a.width_px > 2 * kWindow);
  const auto count = static_cast<std::size_t>(disparities);
  Prepare(static_cast<std::size_t>(a.width_px), static_cast<std::size_t>(a.height_px), count);
  disparity_px.resize(width_ * height_);
  SumDifferences(a, b, count);
  SearchDown(a, count);
  SearchUp(a, count, disparity_px);
}

void SpeckleFilter::Clean(int width_px, int height_px, int least_px, float step_px,
                          std::vector<float>& disparity_px) {
  const auto width = static_cast<std::uint32_t>(width_px);
  const auto pixels = static_cast<std::uint32_t>(width_px * height_px);
  visited_.assign(pixels, 0);
  for (std::uint32_t seed = 0; seed < pixels; ++seed) {
    if (visited_[seed] != 0 || disparity_px[seed] < 0.0F) continue;
    region_.assign(1, seed);
    visited_[seed] = 1;
    for (std::size_t next = 0; next < region_.size(); ++next) {
      const std::uint32_t here = region_[next];
      const auto try_neighbour = [&](std::uint32_t there) {
        if (visited_[there] != 0 || disparity_px[there] < 0.0F) return;
        if (std::abs(disparity_px[there] - disparity_px[here]) > step_px) return;
        visited_[there] = 1;
        region_.push_back(there);
      };
      const std::uint32_t x = here % width;
      if (x > 0) try_neighbour(here - 1);
      if (x + 1 < width) try_neighbour(here + 1);
      if (here >= width) try_neighbour(here - width);
      if (here + width < pixels) try_neighbour(here + width);
    }
    if (region_.size() >= static_cast<std::size_t>(least_px)) continue;
    for (const std::uint32_t pixel : region_) disparity_px[pixel] = CoarseMatcher::kUnknown;
  }
}

}  // namespace kawara::vision
