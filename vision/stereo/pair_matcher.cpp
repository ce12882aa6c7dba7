#include "vision/stereo/pair_matcher.hpp"

#include <algorithm>
#include <cmath>

#include "core/check.hpp"
#include "vision/stereo/range_kernel.hpp"
#include "vision/stereo/semi_global_kernel.hpp"

namespace kawara::vision {
namespace {

/// Of the epipolar grid, in parts of the camera's mean resolution: a mirror camera is dense in
/// azimuth near its outer circle only, and there the disparities gain nothing from it.
constexpr double kGridDensity = 0.9;
/// Above this [px / rad] the search is at a quarter of the size, with a refinement at half between.
constexpr double kDense = 400.0;
/// Regions smaller than this [half-size pixels] stand for nothing; their neighbours are within a
/// step.
constexpr int kSpeckle = 25;
constexpr float kSpeckleStep = 1.0F;
constexpr int kLane = static_cast<int>(semi_global::kLane);

}  // namespace

core::Expected<void> PairMatcher::Match(const StereoView& a, const StereoView& b,
                                        RangeImage& ranges, const StepDoubt& doubt) {
  const auto pair = EpipolarPair::FromPoses(a.map_from_camera, b.map_from_camera);
  if (!pair) return tl::unexpected(pair.error());
  const double px_per_rad =
      options_.px_per_rad > 0.0 ? options_.px_per_rad : kGridDensity * a.camera->mean_px_per_rad();
  const EpipolarGrid grid = EpipolarGrid::Make(px_per_rad, options_.pole_cap_rad);
  rectifier_.Rectify(*a.camera, a.picture, pair->a_from_epipolar, grid, rectified_a_);
  rectifier_.Rectify(*b.camera, b.picture, pair->b_from_epipolar, grid, rectified_b_);
  const bool dense = grid.px_per_rad > kDense;
  if (dense) {
    Halve(rectified_a_, half_a_);
    Halve(rectified_b_, half_b_);
    SearchCoarsely(half_a_, half_b_, pair->baseline_m);
    refiner_.Refine(half_a_, half_b_, coarse_px_, half_field_);
    refiner_.Refine(rectified_a_, rectified_b_, half_field_.disparity_px, field_);
  } else {
    SearchCoarsely(rectified_a_, rectified_b_, pair->baseline_m);
    refiner_.Refine(rectified_a_, rectified_b_, coarse_px_, field_);
  }
  ToRanges(*a.camera, *pair, doubt, ranges);
  return {};
}

void PairMatcher::SearchCoarsely(const RectifiedPicture& a, const RectifiedPicture& b,
                                 double baseline_m) {
  contrast_.Make(a, contrast_a_);
  contrast_.Make(b, contrast_b_);
  const double widest_px =
      1.05 * std::atan2(baseline_m, options_.nearest_m) * a.grid.px_per_rad / 2.0;
  const int disparities = std::max(kLane, (static_cast<int>(widest_px) + kLane) / kLane * kLane);
  coarse_.Match(contrast_a_, contrast_b_, disparities, coarse_px_);
  speckles_.Clean(contrast_a_.width_px, contrast_a_.height_px, kSpeckle, kSpeckleStep, coarse_px_);
}

void PairMatcher::ToRanges(const StereoCamera& camera, const EpipolarPair& pair,
                           const StepDoubt& doubt, RangeImage& ranges) const {
  const MaskedRays& rays = camera.rays();
  const EpipolarGrid& grid = rectified_a_.grid;
  range::FieldView view;
  view.disparity_px = field_.disparity_px.data();
  view.sd_px = field_.sd_px.data();
  view.width = grid.width_px;
  view.height = grid.height_px;
  view.px_per_rad = static_cast<float>(grid.px_per_rad);
  view.first_alpha_rad = static_cast<float>(grid.first_alpha_rad);
  view.baseline_m = static_cast<float>(pair.baseline_m);
  view.turn_sd_rad = static_cast<float>(doubt.turn_sd_rad);
  view.length_relative_sd = static_cast<float>(doubt.length_relative_sd);
  for (int i = 0; i < 9; ++i) {
    view.epipolar_from_camera[i] = static_cast<float>(pair.a_from_epipolar(i % 3, i / 3));
  }
  ranges.Reset(rays.width_px(), rays.height_px());
  const std::size_t pixels = ranges.range_m.size();
  const auto largest = static_cast<float>(options_.largest_relative_sd);
  // Blocks of whole vectors; the last one on copies.
  constexpr std::size_t kBlock = 256;
  float range_m[kBlock], sd_m[kBlock];
  for (std::size_t i = 0; i < pixels; i += kBlock) {
    const std::size_t count = std::min(kBlock, pixels - i);
    range::RangesOfRow(view, rays.x() + i, rays.y() + i, rays.z() + i, count, range_m, sd_m);
    for (std::size_t k = 0; k < count; ++k) {
      if (!(sd_m[k] <= largest * range_m[k])) continue;
      ranges.range_m[i + k] = range_m[k];
      ranges.sd_m[i + k] = sd_m[k];
    }
  }
}

}  // namespace kawara::vision
