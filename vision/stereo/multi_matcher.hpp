#pragma once
#include <span>
#include <vector>

#include "core/expected.hpp"
#include "vision/stereo/pair_matcher.hpp"
#include "vision/stereo/range_fusion.hpp"

namespace kawara::vision {

struct MultiMatcherOptions {
  PairMatcherOptions pair = {};
  RangeFusionOptions fusion = {};
  int threads = 1;  ///< each has a matcher, and its memory, of its own; the result is the same
};

/// The distance image of a view by its pairs with several others: what is hidden from one, near
/// the pole of its baseline, or mistaken in it, is right in others. Pictures before AND behind at a
/// quarter and a half of a metre give most of what there is to gain: near surfaces look too
/// different from farther off.
///
/// Keeps its memory from view to view; one call at a time.
class MultiMatcher {
 public:
  explicit MultiMatcher(const MultiMatcherOptions& options);

  /// `doubts`: none, or one for the step to each of the others; up to kMostRangeEstimates others
  /// (CORE_CHECK both). A view from the same place as `a` is left out. kInvalidArgument: no view is
  /// left.
  core::Expected<void> Match(const StereoView& a, std::span<const StereoView> others,
                             RangeImage& ranges, std::span<const StepDoubt> doubts = {});

  /// Of the last Match, in the order of its others; empty images where one was left out.
  std::span<const RangeImage> of_pairs() const { return {images_.data(), used_.size()}; }

 private:
  MultiMatcherOptions options_;
  std::vector<PairMatcher> matchers_;
  std::vector<RangeImage> images_;
  std::vector<char> used_;
};

}  // namespace kawara::vision
