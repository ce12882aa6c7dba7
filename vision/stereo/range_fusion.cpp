#include "vision/stereo/range_fusion.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/check.hpp"
#include "vision/stereo/fusion_kernel.hpp"

namespace kawara::vision {
namespace {

using fusion::kBlock;

fusion::Rules RulesOf(const RangeFusionOptions& options) {
  fusion::Rules rules;
  rules.agreement_square = static_cast<float>(options.agreement_sd * options.agreement_sd);
  rules.directed = static_cast<float>(options.shared_directed);
  rules.alike = static_cast<float>(options.shared_alike);
  rules.alone_square = static_cast<float>(options.alone_factor * options.alone_factor);
  rules.largest_relative_sd = static_cast<float>(options.largest_relative_sd);
  return rules;
}

}  // namespace

void FuseRanges(std::span<const RangeEstimate> estimates, const RangeFusionOptions& options,
                RangeImage& fused) {
  const std::size_t count = estimates.size();
  CORE_CHECK(count >= 1 && count <= kMostRangeEstimates);
  std::array<RangeEstimate, kMostRangeEstimates> sorted;
  std::copy(estimates.begin(), estimates.end(), sorted.begin());
  std::stable_sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(count),
                   [](const RangeEstimate& a, const RangeEstimate& b) {
                     return a.baseline_m.norm() < b.baseline_m.norm();
                   });
  const RangeImage& first = *sorted[0].ranges;
  fused.Reset(first.width_px, first.height_px);
  const std::size_t pixels = fused.range_m.size();

  std::array<fusion::Source, kMostRangeEstimates> sources;
  for (std::size_t k = 0; k < count; ++k) {
    const RangeImage& ranges = *sorted[k].ranges;
    CORE_CHECK(&ranges != &fused);
    CORE_CHECK(ranges.width_px == first.width_px && ranges.height_px == first.height_px);
    CORE_CHECK(ranges.range_m.size() == pixels && ranges.sd_m.size() == pixels);
    const double length_m = sorted[k].baseline_m.norm();
    CORE_CHECK(length_m > 0.0);
    sources[k].range_m = ranges.range_m.data();
    sources[k].sd_m = ranges.sd_m.data();
    for (int i = 0; i < 3; ++i)
      sources[k].direction[i] = static_cast<float>(sorted[k].baseline_m[i] / length_m);
  }
  if (count == 1) {
    fused = first;
    return;
  }
  const fusion::Rules rules = RulesOf(options);
  const std::size_t whole = pixels / kBlock * kBlock;
  fusion::Fuse(sources.data(), count, rules, whole, fused.range_m.data(), fused.sd_m.data());
  const std::size_t rest = pixels - whole;
  if (rest == 0) return;
  // The last pixels on copies that fill a block.
  std::array<std::array<float, 2 * kBlock>, kMostRangeEstimates> copies;
  for (std::size_t k = 0; k < count; ++k) {
    copies[k].fill(RangeImage::kUnknown);
    std::copy_n(sources[k].range_m + whole, rest, copies[k].begin());
    std::copy_n(sources[k].sd_m + whole, rest, copies[k].begin() + kBlock);
    sources[k].range_m = copies[k].data();
    sources[k].sd_m = copies[k].data() + kBlock;
  }
  std::array<float, kBlock> range_m, sd_m;
  fusion::Fuse(sources.data(), count, rules, kBlock, range_m.data(), sd_m.data());
  std::copy_n(range_m.begin(), rest, fused.range_m.begin() + static_cast<std::ptrdiff_t>(whole));
  std::copy_n(sd_m.begin(), rest, fused.sd_m.begin() + static_cast<std::ptrdiff_t>(whole));
}

}  // namespace kawara::vision
