#pragma once
#include <span>
#include <variant>

#include "vision/stereo/multi_matcher.hpp"
#include "vision/stereo/pair_matcher.hpp"
#include "vision/stereo/paper_matcher.hpp"

namespace kawara::mapper {

/// How a pair becomes a distance image.
enum class StereoMethod {
  kFast,   ///< vision::PairMatcher; with several others vision::MultiMatcher
  kPaper,  ///< vision::PaperMatcher: colour edges only, the reference
};

struct StereoOptions {
  StereoMethod method = StereoMethod::kFast;
  double nearest_m = 1.5;
  double px_per_rad = 0.0;  ///< of the fast method's search; 0: the camera's own
  /// Of the fast method: directions nearer to the baseline stay unknown.
  double pole_cap_rad = vision::PairMatcherOptions{}.pole_cap_rad;
};

/// The one place where the method is chosen. One thread at a time.
class StereoMatcher {
 public:
  explicit StereoMatcher(const StereoOptions& options)
      : matcher_(Make(options)), several_({.pair = PairOf(options)}) {}

  /// As both matchers' Match.
  core::Expected<void> Match(const vision::StereoView& a, const vision::StereoView& b,
                             vision::RangeImage& ranges, const vision::StepDoubt& doubt) {
    return std::visit([&](auto& matcher) { return matcher.Match(a, b, ranges, doubt); }, matcher_);
  }
  /// As MultiMatcher's Match; the paper's method takes the first of the others alone.
  core::Expected<void> Match(const vision::StereoView& a,
                             std::span<const vision::StereoView> others, vision::RangeImage& ranges,
                             std::span<const vision::StepDoubt> doubts) {
    if (others.size() == 1 || std::holds_alternative<vision::PaperMatcher>(matcher_)) {
      return Match(a, others.front(), ranges, doubts.front());
    }
    return several_.Match(a, others, ranges, doubts);
  }

 private:
  using Matcher = std::variant<vision::PairMatcher, vision::PaperMatcher>;
  static Matcher Make(const StereoOptions& options) {
    if (options.method == StereoMethod::kPaper)
      return vision::PaperMatcher({.nearest_m = options.nearest_m});
    return vision::PairMatcher(PairOf(options));
  }
  static vision::PairMatcherOptions PairOf(const StereoOptions& options) {
    return {.px_per_rad = options.px_per_rad,
            .nearest_m = options.nearest_m,
            .pole_cap_rad = options.pole_cap_rad};
  }

  Matcher matcher_;
  vision::MultiMatcher several_;  ///< without memory until it is used
};

}  // namespace kawara::mapper
