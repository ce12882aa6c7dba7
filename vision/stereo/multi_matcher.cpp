#include "vision/stereo/multi_matcher.hpp"

#include <algorithm>
#include <atomic>
#include <string>
#include <thread>

#include "core/check.hpp"

namespace kawara::vision {

MultiMatcher::MultiMatcher(const MultiMatcherOptions& options)
    : options_(options),
      matchers_(static_cast<std::size_t>(std::max(1, options.threads)), PairMatcher(options.pair)) {
}

core::Expected<void> MultiMatcher::Match(const StereoView& a, std::span<const StereoView> others,
                                         RangeImage& ranges, std::span<const StepDoubt> doubts) {
  CORE_CHECK(others.size() <= kMostRangeEstimates);
  CORE_CHECK(doubts.empty() || doubts.size() == others.size());
  if (images_.size() < others.size()) images_.resize(others.size());
  used_.assign(others.size(), 0);

  std::atomic<std::size_t> next{0};
  const auto work = [&](PairMatcher& matcher) {
    for (std::size_t i = next++; i < others.size(); i = next++) {
      const StepDoubt doubt = doubts.empty() ? StepDoubt{} : doubts[i];
      used_[i] = matcher.Match(a, others[i], images_[i], doubt) ? 1 : 0;
      if (used_[i] == 0) images_[i].Reset(0, 0);
    }
  };
  {
    std::vector<std::jthread> helpers;
    for (std::size_t t = 1; t < std::min(matchers_.size(), others.size()); ++t) {
      helpers.emplace_back([&work, &matcher = matchers_[t]] { work(matcher); });
    }
    work(matchers_.front());
  }

  std::vector<RangeEstimate> estimates;
  for (std::size_t i = 0; i < others.size(); ++i) {
    if (used_[i] == 0) continue;
    estimates.push_back(
        {&images_[i], others[i].map_from_camera.translation() - a.map_from_camera.translation()});
  }
  if (estimates.empty()) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "none of the " + std::to_string(others.size()) +
                          " other pictures was taken from another place: stereo needs frames "
                          "between which the robot has moved");
  }
  FuseRanges(estimates, options_.fusion, ranges);
  return {};
}

}  // namespace kawara::vision
