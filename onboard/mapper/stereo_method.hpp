#pragma once
#include <variant>

#include "vision/stereo/pair_matcher.hpp"
#include "vision/stereo/paper_matcher.hpp"

namespace kawara::mapper {

/// How a pair becomes a distance image.
enum class StereoMethod {
  kFast,   ///< vision::PairMatcher
  kPaper,  ///< vision::PaperMatcher: colour edges only, the reference
};

struct StereoOptions {
  StereoMethod method = StereoMethod::kFast;
  double nearest_m = 1.5;
  double px_per_rad = 0.0;  ///< of the fast method's search; 0: the camera's own
};

/// The one place where the method is chosen. One thread at a time.
class StereoMatcher {
 public:
  explicit StereoMatcher(const StereoOptions& options) : matcher_(Make(options)) {}

  /// As both matchers' Match.
  core::Expected<void> Match(const vision::StereoView& a, const vision::StereoView& b,
                             vision::RangeImage& ranges, const vision::StepDoubt& doubt) {
    return std::visit([&](auto& matcher) { return matcher.Match(a, b, ranges, doubt); }, matcher_);
  }

 private:
  using Matcher = std::variant<vision::PairMatcher, vision::PaperMatcher>;
  static Matcher Make(const StereoOptions& options) {
    if (options.method == StereoMethod::kPaper)
      return vision::PaperMatcher({.nearest_m = options.nearest_m});
    return vision::PairMatcher({.px_per_rad = options.px_per_rad, .nearest_m = options.nearest_m});
  }

  Matcher matcher_;
};

}  // namespace kawara::mapper
