#pragma once
#include <cstdint>
#include <vector>

#include "vision/stereo/contrast_plane.hpp"

namespace kawara::vision {

/// Dense disparities of two contrast planes, whole steps and a guess of the fraction: summed
/// differences over a small window, semi-global along eight directions (Hirschmueller 2008), kept
/// only where the best is clearly best, where the search from B comes back to it, and where enough
/// neighbours agree. What is plain or repeats itself stays unknown. Integer arithmetic: the same
/// bits on every machine. Keeps its memory; one thread at a time.
class CoarseMatcher {
 public:
  static constexpr float kUnknown = -1.0F;

  /// disparity_px, [height][width] of the planes: from 0 to `disparities` (a multiple of 16), or
  /// kUnknown. Both planes of the same size.
  void Match(const ContrastPlane& a, const ContrastPlane& b, int disparities,
             std::vector<float>& disparity_px);

 private:
  struct Paths {
    std::vector<std::uint16_t> cost, least;
  };
  void Prepare(std::size_t width, std::size_t height, std::size_t disparities);
  void SumDifferences(const ContrastPlane& a, const ContrastPlane& b, std::size_t disparities);
  void SearchDown(const ContrastPlane& a, std::size_t disparities);
  void SearchUp(const ContrastPlane& a, std::size_t disparities, std::vector<float>& disparity_px);
  void ChooseRow(const ContrastPlane& a, std::size_t y, std::size_t disparities,
                 float* disparity_px);

  std::size_t width_ = 0, height_ = 0;
  std::vector<std::uint8_t> differences_;  ///< the window's rows, in turn
  std::vector<std::uint16_t> row_sum_;
  std::vector<std::uint8_t> b_row_, b_seen_row_;
  std::vector<std::uint8_t> cost_;    ///< [height][width][disparities]
  std::vector<std::uint16_t> total_;  ///< the same
  Paths rows_[2][3], along_;
  std::vector<std::uint16_t> best_, best_cost_, second_cost_, b_best_, b_cost_;
  std::vector<std::uint8_t> repeats_;
};

/// Takes away (CoarseMatcher::kUnknown) connected regions of fewer than `least_px` pixels;
/// neighbours are connected when they differ by at most `step_px`.
class SpeckleFilter {
 public:
  void Clean(int width_px, int height_px, int least_px, float step_px,
             std::vector<float>& disparity_px);

 private:
  std::vector<std::uint8_t> visited_;
  std::vector<std::uint32_t> region_;
};

}  // namespace kawara::vision
