#include "tools/navigate/reference_errors.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::navigate {
namespace {

constexpr core::Duration kLongestStretch = core::Seconds(1);

}  // namespace

void ErrorSum::Add(const Eigen::Vector3d& ned_m) {
  ++count;
  square_sum_m2 += ned_m.cwiseAbs2();
  worst_horizontal_m = std::max(worst_horizontal_m, ned_m.head<2>().norm());
}

Eigen::Vector3d ErrorSum::RmsNed() const {
  return (square_sum_m2 / static_cast<double>(count)).cwiseSqrt();
}

ReferenceErrors::ReferenceErrors(const std::vector<Reference>& references,
                                 const Eigen::Vector3d& lever_frd_m)
    : references_(references), lever_frd_m_(lever_frd_m), residual_(references.size()) {}

void ReferenceErrors::AddStretch(const estimation::NavSolution& earlier,
                                 const estimation::NavSolution& later) {
  if (!earlier.valid() || !later.valid()) return;
  if (later.time <= earlier.time || later.time - earlier.time > kLongestStretch) return;
  auto reference =
      std::ranges::lower_bound(references_, earlier.time, {}, [](const auto& r) { return r.time; });
  // The far end belongs to the next stretch, but the last stretch has no next.
  for (; reference != references_.end() && reference->time <= later.time; ++reference) {
    const estimation::NavSolution there = estimation::MovedTo(
        estimation::Interpolated(earlier, later, reference->time), lever_frd_m_);
    residual_[static_cast<std::size_t>(reference - references_.begin())] =
        core::NedBetween(there.position, reference->antenna);
  }
}

ErrorSum ReferenceErrors::HeldOut(core::RtkState rtk) const {
  ErrorSum sum;
  for (std::size_t i = 0; i < references_.size(); ++i) {
    const Reference& reference = references_[i];
    if (reference.role == Reference::Role::kHeldOut && reference.rtk == rtk && residual_[i]) {
      sum.Add(*residual_[i]);
    }
  }
  return sum;
}

std::int64_t ReferenceErrors::held_out_uncovered() const {
  std::int64_t count = 0;
  for (std::size_t i = 0; i < references_.size(); ++i) {
    if (references_[i].role == Reference::Role::kHeldOut && !residual_[i]) ++count;
  }
  return count;
}

std::vector<WindowError> ReferenceErrors::Blanked(const std::vector<TimeWindow>& windows) const {
  std::vector<WindowError> errors;
  errors.reserve(windows.size());
  for (const TimeWindow& window : windows) errors.push_back({window});
  for (std::size_t i = 0; i < references_.size(); ++i) {
    const Reference& reference = references_[i];
    if (reference.role != Reference::Role::kBlanked || reference.rtk != core::RtkState::kFixed ||
        !residual_[i]) {
      continue;
    }
    WindowError& error = errors[reference.window];
    ++error.count;
    error.worst_horizontal_m = std::max(error.worst_horizontal_m, residual_[i]->head<2>().norm());
  }
  return errors;
}

double RmsOfWorst(const std::vector<WindowError>& windows) {
  double sum = 0.0;
  std::int64_t count = 0;
  for (const WindowError& window : windows) {
    if (window.count == 0) continue;
    sum += window.worst_horizontal_m * window.worst_horizontal_m;
    ++count;
  }
  return std::sqrt(sum / static_cast<double>(count));
}

}  // namespace kawara::navigate
